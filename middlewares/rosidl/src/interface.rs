//! Messages, services and actions of ROS 2, as data.

use std::fmt;

use crate::names::TypeName;

/// Type of a field or of its elements.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Base {
    /// `bool`
    Bool,
    /// `byte`, which is a `uint8` under another name.
    Byte,
    /// `int8`
    Int8,
    /// `uint8`, and `char`.
    UInt8,
    /// `int16`
    Int16,
    /// `uint16`
    UInt16,
    /// `int32`
    Int32,
    /// `uint32`
    UInt32,
    /// `int64`
    Int64,
    /// `uint64`
    UInt64,
    /// `float32`
    Float32,
    /// `float64`
    Float64,
    /// `string`, `string<=n`
    String(Option<u32>),
    /// `wstring`, `wstring<=n`
    WString(Option<u32>),
    /// A nested message.
    Message(TypeName),
}

/// Number of values in a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Shape {
    /// A single value.
    One,
    /// `T[n]`
    Array(u32),
    /// `T[]`, `T[<=n]`
    Sequence(Option<u32>),
}

/// A member of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Name; valid in ROS.
    pub name: String,
    /// Type of the value or of its elements.
    pub base: Base,
    /// Number of values.
    pub shape: Shape,
    /// Comment at the end of its line.
    pub comment: Option<String>,
}

impl Field {
    /// A single value.
    #[must_use]
    pub fn one(name: &str, base: Base) -> Self {
        Self { name: name.to_owned(), base, shape: Shape::One, comment: None }
    }
}

/// A constant of a message; not part of its encoding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constant {
    /// Name; valid in ROS.
    pub name: String,
    /// Type of the value.
    pub base: Base,
    /// The value as it is written in the file.
    pub value: String,
}

/// A message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// Full name.
    pub name: TypeName,
    /// Fields in order. If there are none, ROS sends one byte.
    pub fields: Vec<Field>,
    /// Constants in order.
    pub constants: Vec<Constant>,
    /// Comment in the first line of the file: where the message comes from.
    pub comment: Option<String>,
}

impl Message {
    /// A message without fields.
    #[must_use]
    pub fn new(name: TypeName) -> Self {
        Self { name, fields: Vec::new(), constants: Vec::new(), comment: None }
    }
}

/// A service: request and response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Service {
    /// Full name.
    pub name: TypeName,
    /// `NAME_Request`
    pub request: Message,
    /// `NAME_Response`
    pub response: Message,
}

/// An action: goal, result and feedback.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Action {
    /// Full name.
    pub name: TypeName,
    /// `NAME_Goal`
    pub goal: Message,
    /// `NAME_Result`
    pub result: Message,
    /// `NAME_Feedback`
    pub feedback: Message,
}

/// What an action is made of where it is used: it is no kind of its own there.
impl Action {
    fn one(name: &str, ty: TypeName) -> Field {
        Field::one(name, Base::Message(ty))
    }

    fn id() -> Field {
        Self::one("goal_id", TypeName::new("unique_identifier_msgs", "msg", "UUID"))
    }

    fn part(&self, suffix: &str, fields: Vec<Field>) -> Message {
        Message { fields, ..Message::new(self.name.part(suffix)) }
    }

    /// The service that takes goals.
    #[must_use]
    pub fn send_goal(&self) -> Service {
        let goal = Self::one("goal", self.goal.name.clone());
        let stamp = Self::one("stamp", TypeName::new("builtin_interfaces", "msg", "Time"));
        let accepted = Field::one("accepted", Base::Bool);
        Service {
            name: self.name.part("_SendGoal"),
            request: self.part("_SendGoal_Request", vec![Self::id(), goal]),
            response: self.part("_SendGoal_Response", vec![accepted, stamp]),
        }
    }

    /// The service that gives the results of goals.
    #[must_use]
    pub fn get_result(&self) -> Service {
        let status = Field::one("status", Base::Int8);
        let result = Self::one("result", self.result.name.clone());
        Service {
            name: self.name.part("_GetResult"),
            request: self.part("_GetResult_Request", vec![Self::id()]),
            response: self.part("_GetResult_Response", vec![status, result]),
        }
    }

    /// The message on the topic of feedback.
    #[must_use]
    pub fn feedback_message(&self) -> Message {
        let feedback = Self::one("feedback", self.feedback.name.clone());
        self.part("_FeedbackMessage", vec![Self::id(), feedback])
    }
}

/// A message, a service or an action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Interface {
    /// `.msg`
    Message(Message),
    /// `.srv`
    Service(Service),
    /// `.action`
    Action(Action),
}

impl Interface {
    /// Full name.
    #[must_use]
    pub fn name(&self) -> &TypeName {
        match self {
            Interface::Message(message) => &message.name,
            Interface::Service(service) => &service.name,
            Interface::Action(action) => &action.name,
        }
    }

    /// The messages that it consists of.
    pub fn parts(&self) -> impl Iterator<Item = &Message> {
        match self {
            Interface::Message(message) => vec![message],
            Interface::Service(service) => vec![&service.request, &service.response],
            Interface::Action(action) => vec![&action.goal, &action.result, &action.feedback],
        }
        .into_iter()
    }
}

impl fmt::Display for Base {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self {
            Base::Bool => "bool",
            Base::Byte => "byte",
            Base::Int8 => "int8",
            Base::UInt8 => "uint8",
            Base::Int16 => "int16",
            Base::UInt16 => "uint16",
            Base::Int32 => "int32",
            Base::UInt32 => "uint32",
            Base::Int64 => "int64",
            Base::UInt64 => "uint64",
            Base::Float32 => "float32",
            Base::Float64 => "float64",
            Base::String(None) => "string",
            Base::WString(None) => "wstring",
            Base::String(Some(most)) => return write!(f, "string<={most}"),
            Base::WString(Some(most)) => return write!(f, "wstring<={most}"),
            Base::Message(name) => return write!(f, "{}/{}", name.package, name.name),
        };
        f.write_str(name)
    }
}

impl fmt::Display for Shape {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Shape::One => Ok(()),
            Shape::Array(count) => write!(f, "[{count}]"),
            Shape::Sequence(None) => f.write_str("[]"),
            Shape::Sequence(Some(most)) => write!(f, "[<={most}]"),
        }
    }
}
