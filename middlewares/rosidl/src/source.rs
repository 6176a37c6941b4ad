//! The texts of which types are made, as nodes give them to who asks for a type.

use crate::description::Description;
use crate::interface::{Interface, Message};
use crate::names::TypeName;

/// The text of a type: a `type_description_interfaces/msg/TypeSource`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// Its name.
    pub name: TypeName,
    /// `msg`, `srv` or `action`; `implicit` for a part of a service or an action, which has no text.
    pub encoding: &'static str,
    /// The text.
    pub text: String,
}

impl Source {
    fn of_message(message: &Message) -> Self {
        match message.name.folder.as_str() {
            "msg" => Self::new(&message.name, "msg", message.to_string()),
            _ => Self::implicit(&message.name),
        }
    }

    fn of(interface: &Interface) -> Self {
        let name = interface.name();
        match interface {
            Interface::Message(message) => Self::of_message(message),
            Interface::Service(_) if name.folder == "srv" => {
                Self::new(name, "srv", interface.to_string())
            }
            Interface::Service(_) => Self::implicit(name),
            Interface::Action(_) => Self::new(name, "action", interface.to_string()),
        }
    }

    fn new(name: &TypeName, encoding: &'static str, text: String) -> Self {
        Self { name: name.clone(), encoding, text }
    }

    fn implicit(name: &TypeName) -> Self {
        Self::new(name, "implicit", String::new())
    }
}

/// The texts of an interface and of all within it.
#[must_use]
pub fn sources(interface: &Interface, description: &Description) -> Vec<Source> {
    let others = description.others.iter().map(Source::of_message);
    std::iter::once(Source::of(interface)).chain(others).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::standard;

    #[test]
    fn the_texts_of_an_action_are_those_that_a_node_of_ros_gives() {
        let name = TypeName::new("test_msgs", "action", "Fibonacci");
        let whole = &standard::all()[&name];
        let description = Description::of(whole, &standard::message).unwrap();
        let all = sources(whole, &description);
        let told: Vec<_> = all.iter().map(|one| format!("{} {}", one.name, one.encoding)).collect();
        // What rclpy of Jazzy answered.
        assert_eq!(
            told,
            [
                "test_msgs/action/Fibonacci action",
                "builtin_interfaces/msg/Time msg",
                "service_msgs/msg/ServiceEventInfo msg",
                "test_msgs/action/Fibonacci_Feedback implicit",
                "test_msgs/action/Fibonacci_FeedbackMessage implicit",
                "test_msgs/action/Fibonacci_GetResult implicit",
                "test_msgs/action/Fibonacci_GetResult_Event implicit",
                "test_msgs/action/Fibonacci_GetResult_Request implicit",
                "test_msgs/action/Fibonacci_GetResult_Response implicit",
                "test_msgs/action/Fibonacci_Goal implicit",
                "test_msgs/action/Fibonacci_Result implicit",
                "test_msgs/action/Fibonacci_SendGoal implicit",
                "test_msgs/action/Fibonacci_SendGoal_Event implicit",
                "test_msgs/action/Fibonacci_SendGoal_Request implicit",
                "test_msgs/action/Fibonacci_SendGoal_Response implicit",
                "unique_identifier_msgs/msg/UUID msg",
            ]
        );
        assert_eq!(all[0].text, "int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n");
        assert!(all.iter().all(|one| one.text.is_empty() == (one.encoding == "implicit")));
    }
}
