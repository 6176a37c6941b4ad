//! Reasons why a parameter is not set, as reported to the ROS node that requested it.

use std::fmt::{Display, Formatter};

use genom_middleware::CallError;
use genom_types::JsonError;
use serde_json::Value as Json;

/// A parameter is not set, and keeps its value.
#[derive(Debug, PartialEq, thiserror::Error)]
pub(crate) enum SetError {
    #[error("the component is gone")]
    Gone,
    #[error("there is no parameter `{0}`")]
    Unknown(String),
    #[error("`{0}` can only be read")]
    ReadOnly(String),
    /// `use_sim_time` is false, and no component can change that.
    #[error(
        "the clock of all components is that of the daemon: start it with `clock = \"ros\"`, \
         `genomd --clock ros`, for the time of a simulator"
    )]
    OwnTime,
    /// It is true, and no component can change that.
    #[error(
        "the clock of all components is that of the daemon: start it without `clock = \"ros\"`, \
         `genomd --clock monotonic`, for the time of the machine"
    )]
    SimulatedTime,
    /// Several parameters in a request for setting them atomically.
    #[error("attributes are set one by one: use set_parameters")]
    Several,
    #[error("it is of type {wanted}, not {given}")]
    Type { wanted: &'static str, given: &'static str },
    #[error("it has {wanted} elements, not {given}")]
    Length { wanted: usize, given: usize },
    /// The value has the right type, but is out of range, too long or not an enumerator.
    #[error(transparent)]
    Value(#[from] JsonError),
    /// The attribute's validate codel refused the value.
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
