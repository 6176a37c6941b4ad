//! Why a parameter is not set, in the words that the ROS node which asked is given.

use std::fmt::{Display, Formatter};

use genom_middleware::CallError;
use genom_types::JsonError;
use serde_json::Value as Json;

/// A parameter keeps the value it has.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum SetError {
    #[error("the component is gone")]
    Gone,
    #[error("there is no parameter `{0}`")]
    Unknown(String),
    #[error("`{0}` can only be read")]
    ReadOnly(String),
    /// More than one in a request that is to be done as a whole or not at all.
    #[error("attributes are set one by one: use set_parameters")]
    Several,
    #[error("it is of type {wanted}, not {given}")]
    Type { wanted: &'static str, given: &'static str },
    #[error("it has {wanted} elements, not {given}")]
    Length { wanted: usize, given: usize },
    /// Of the right type, but out of range, too long or no enumerator.
    #[error(transparent)]
    Value(#[from] JsonError),
    /// The attribute has a validate codel, which refused.
    #[error("{}", Exception(.name, .detail))]
    Exception { name: String, detail: Json },
    #[error(transparent)]
    Lost(#[from] CallError),
}

/// An exception, with its members if it has any.
struct Exception<'a>(&'a str, &'a Json);

impl Display for Exception<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0)?;
        if self.1.is_null() { Ok(()) } else { write!(f, " {}", self.1) }
    }
}
