//! Messages, services and actions of ROS 2, as data.

use std::fmt;

use crate::names::TypeName;

/// What a field holds, but for arrays.
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
    /// Another message.
    Message(TypeName),
}

/// How many of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Shape {
    /// One.
    One,
    /// `T[n]`
    Array(u32),
    /// `T[]`, `T[<=n]`
    Sequence(Option<u32>),
}

/// A member of a message.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name, legal in ROS.
    pub name: String,
    /// What it holds.
    pub base: Base,
    /// How many of them.
    pub shape: Shape,
    /// Written behind it.
    pub comment: Option<String>,
}

impl Field {
    /// A single value.
    #[must_use]
    pub fn one(name: &str, base: Base) -> Self {
        Self { name: name.to_owned(), base, shape: Shape::One, comment: None }
    }
}

/// A constant of a message; it is on no wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Constant {
    /// Its name, legal in ROS.
    pub name: String,
    /// Its type.
    pub base: Base,
    /// As it is written.
    pub value: String,
}

/// Members in order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// What it is called.
    pub name: TypeName,
    /// Its members; ROS sends one byte where there are none.
    pub fields: Vec<Field>,
    /// Its constants.
    pub constants: Vec<Constant>,
    /// First line of its text: where it comes from.
    pub comment: Option<String>,
}

impl Message {
    /// Without members, so far.
    #[must_use]
    pub fn new(name: TypeName) -> Self {
        Self { name, fields: Vec::new(), constants: Vec::new(), comment: None }
    }
}

/// Request and response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Service {
    /// What it is called.
    pub name: TypeName,
    /// `NAME_Request`
    pub request: Message,
    /// `NAME_Response`
    pub response: Message,
}

/// Goal, result and feedback.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Action {
    /// What it is called.
    pub name: TypeName,
    /// `NAME_Goal`
    pub goal: Message,
    /// `NAME_Result`
    pub result: Message,
    /// `NAME_Feedback`
    pub feedback: Message,
}

/// Any of them.
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
    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &TypeName {
        match self {
            Interface::Message(message) => &message.name,
            Interface::Service(service) => &service.name,
            Interface::Action(action) => &action.name,
        }
    }

    /// The messages it is made of.
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
