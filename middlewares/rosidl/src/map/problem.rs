//! Reasons why a type has no equivalent in ROS.

use std::fmt;

use genom_types::ScopedName;

use crate::names::TypeName;

/// A place in a description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A type.
    Type(ScopedName),
    /// A member of a struct, union or exception; or a parameter, whose struct is
    /// `::component::service::input` or `::output`.
    Member(ScopedName, String),
    /// An unnamed type that the caller asked for.
    Nameless,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::Type(name) => name.fmt(f),
            Place::Member(of, name) => write!(f, "{of}::{name}"),
            Place::Nameless => f.write_str("the type"),
        }
    }
}

/// A type has no equivalent in ROS.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {problem}; {}", .problem.help())]
pub struct MapError {
    /// Where the problem is.
    pub place: Place,
    /// What the problem is.
    pub problem: Box<Problem>,
}

/// What is wrong with a type.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// A `native` type: a pointer that only codels understand.
    #[error("a native type has no equivalent in ROS")]
    Native,
    /// `any`, or a type that was declared and never defined.
    #[error("a type without definite content has no equivalent in ROS")]
    Incomplete,
    /// The type contains itself.
    #[error("a type that contains itself has no equivalent in ROS")]
    Recursive,
    /// A string that can hold only the empty string.
    #[error("a string that can only be empty has no equivalent in ROS")]
    EmptyString,
    /// An array without elements.
    #[error("an array of no elements has no equivalent in ROS")]
    EmptyArray,
    /// A struct without members.
    #[error("a struct without members has no equivalent in ROS within another type")]
    EmptyStruct,
    /// The name cannot be turned into a valid member name.
    #[error("`{0}` cannot be the name of a field in ROS")]
    Member(String),
    /// Two members would get the same name.
    #[error("it would be called `{0}` in ROS, as `{1}` is")]
    MemberClash(String, String),
    /// Two types would get the same name.
    #[error("it would be {0} in ROS, as {1} is")]
    TypeClash(TypeName, String),
    /// The name cannot be turned into a valid type name.
    #[error("{0} is no legal name in ROS")]
    TypeName(TypeName),
    /// The name is longer than DDS allows.
    #[error("{0} is longer than the {1} characters that DDS allows for the name of a type")]
    TooLong(TypeName, usize),
}

impl Problem {
    /// How to solve it.
    #[must_use]
    pub fn help(&self) -> &'static str {
        match self {
            Problem::Native => "keep it in the IDS, and send what others can read",
            Problem::Incomplete => "give it a definite content",
            Problem::Recursive => "refer to the inner ones by their rank in a sequence beside",
            Problem::EmptyString => "string<2> holds one character",
            Problem::EmptyArray | Problem::EmptyStruct => "leave it out, or give it a member",
            Problem::Member(_) | Problem::TypeName(_) => {
                "begin it with a letter, and use letters, digits and single underscores"
            }
            Problem::MemberClash(..) | Problem::TypeClash(..) => "rename one of them",
            Problem::TooLong(..) => "shorten it",
        }
    }
}
