//! The description of a type: of itself and of all types within it, down to basic ones (REP-2016).
//!
//! It is what the hash of a type is made of, and what nodes answer who asks for a type.

use std::collections::BTreeMap;

use crate::interface::{Base, Field, Interface, Message, Service, Shape};
use crate::names::TypeName;
use crate::structure::Find;

/// The definition of a type within the described one is missing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0} has to be known for the description of a type that contains it")]
pub struct Missing(pub TypeName);

/// A type, and all types within it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Description {
    /// The type itself. A service or an action consists of its parts.
    pub whole: Message,
    /// Those within, sorted by their names as texts.
    pub others: Vec<Message>,
}

/// The type of a field in numbers, as `type_description_interfaces/msg/FieldType` has it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FieldType {
    /// Basic type, or that it is a message, and whether there are several.
    pub id: u8,
    /// Length of an array, bound of a sequence.
    pub capacity: u32,
    /// Bound of strings.
    pub string_capacity: u32,
    /// The message.
    pub nested: String,
}

impl Description {
    /// Describes an interface. `find` looks up the messages within.
    ///
    /// # Errors
    /// `find` does not know one of them.
    pub fn of(interface: &Interface, find: Find<'_>) -> Result<Self, Missing> {
        let mut all = BTreeMap::new();
        let whole = whole(interface, &mut all);
        let mut todo: Vec<Message> = all.values().cloned().chain([whole.clone()]).collect();
        while let Some(message) = todo.pop() {
            for field in &message.fields {
                let Base::Message(name) = &field.base else { continue };
                if all.contains_key(name) {
                    continue;
                }
                let found = find(name).or_else(|| implied(name));
                let inner = found.ok_or_else(|| Missing(name.clone()))?;
                all.insert(name.clone(), inner.clone());
                todo.push(inner);
            }
        }
        let mut others: Vec<Message> = all.into_values().collect();
        others.sort_by_cached_key(|message| message.name.to_string());
        Ok(Self { whole, others })
    }
}

/// The fields of a message. ROS has no empty ones.
pub fn fields(message: &Message) -> Vec<Field> {
    match message.fields.as_slice() {
        [] => vec![Field::one("structure_needs_at_least_one_member", Base::UInt8)],
        fields => fields.to_vec(),
    }
}

impl FieldType {
    /// The type of a field.
    #[must_use]
    pub fn of(field: &Field) -> Self {
        let (id, string_capacity, nested) = match &field.base {
            Base::Message(name) => (1, 0, name.to_string()),
            Base::Int8 => (2, 0, String::new()),
            Base::UInt8 => (3, 0, String::new()),
            Base::Int16 => (4, 0, String::new()),
            Base::UInt16 => (5, 0, String::new()),
            Base::Int32 => (6, 0, String::new()),
            Base::UInt32 => (7, 0, String::new()),
            Base::Int64 => (8, 0, String::new()),
            Base::UInt64 => (9, 0, String::new()),
            Base::Float32 => (10, 0, String::new()),
            Base::Float64 => (11, 0, String::new()),
            Base::Bool => (15, 0, String::new()),
            Base::Byte => (16, 0, String::new()),
            Base::String(None) => (17, 0, String::new()),
            Base::WString(None) => (18, 0, String::new()),
            Base::String(Some(most)) => (21, *most, String::new()),
            Base::WString(Some(most)) => (22, *most, String::new()),
        };
        let (more, capacity) = match field.shape {
            Shape::One => (0, 0),
            Shape::Array(count) => (48, count),
            Shape::Sequence(Some(most)) => (96, most),
            Shape::Sequence(None) => (144, 0),
        };
        Self { id: id + more, capacity, string_capacity, nested }
    }
}

/// The interface as a single message. Adds the messages that it consists of to `all`.
fn whole(interface: &Interface, all: &mut BTreeMap<TypeName, Message>) -> Message {
    match interface {
        Interface::Message(message) => message.clone(),
        Interface::Service(service) => service_message(service, all),
        Interface::Action(action) => {
            let name = &action.name;
            let (send, get) = (action.send_goal(), action.get_result());
            let feedback = action.feedback_message();
            for message in [&action.goal, &action.result, &action.feedback, &feedback] {
                all.insert(message.name.clone(), message.clone());
            }
            for service in [&send, &get] {
                let message = service_message(service, all);
                all.insert(message.name.clone(), message);
            }
            let fields = [
                ("goal", "_Goal"),
                ("result", "_Result"),
                ("feedback", "_Feedback"),
                ("send_goal_service", "_SendGoal"),
                ("get_result_service", "_GetResult"),
                ("feedback_message", "_FeedbackMessage"),
            ];
            let fields = fields.map(|(field, suffix)| one(field, name.part(suffix)));
            Message { fields: fields.into(), ..Message::new(name.clone()) }
        }
    }
}

fn one(name: &str, ty: TypeName) -> Field {
    Field::one(name, Base::Message(ty))
}

fn service_message(service: &Service, all: &mut BTreeMap<TypeName, Message>) -> Message {
    let event = service.name.part("_Event");
    let at_most_one = |name: &str, ty: &TypeName| Field {
        shape: Shape::Sequence(Some(1)),
        ..one(name, ty.clone())
    };
    let info = TypeName::new("service_msgs", "msg", "ServiceEventInfo");
    let fields = vec![
        one("info", info),
        at_most_one("request", &service.request.name),
        at_most_one("response", &service.response.name),
    ];
    let event = Message { fields, ..Message::new(event) };
    for message in [&service.request, &service.response, &event] {
        all.insert(message.name.clone(), message.clone());
    }
    let fields = vec![
        one("request_message", service.request.name.clone()),
        one("response_message", service.response.name.clone()),
        one("event_message", event.name),
    ];
    Message { fields, ..Message::new(service.name.clone()) }
}

/// Messages that are part of every service and action.
fn implied(name: &TypeName) -> Option<Message> {
    crate::standard::message(name)
}
