//! Inputs of a service: as they are given, and why they are refused, in the words of who typed
//! them.

use std::sync::{Arc, Mutex};

use genom_types::{JsonError, JsonProblem, Record};
use serde_json::Value;

/// Inputs of a request.
#[derive(Debug)]
pub enum Asked {
    /// All of them.
    Whole(Record),
    /// Some inputs of an attribute.
    Partial(Value),
}

/// What becomes of inputs that are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Those of an attribute keep their value, others take their default; what has none is missing.
    Kept,
    /// All take their default, or zero.
    Zero,
}

/// What came of inputs that were given in part; known when the request is done.
#[derive(Debug, Default)]
pub(super) struct Completed {
    /// All of them, as they were set.
    pub(super) inputs: Option<Value>,
    pub(super) refused: Option<InputError>,
}

/// The same, shared with the request.
pub(super) type Completion = Arc<Mutex<Completed>>;

/// Inputs that are none of a service; nothing was sent.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct InputError {
    message: String,
    /// Where, as `goal.x[2]`; empty for the inputs themselves.
    pub path: String,
    /// It is not there, and has no default.
    pub missing: bool,
    /// Whether it is wrong depends on what the component holds: the member of a union.
    pub(super) depends: bool,
}

impl InputError {
    /// The record of inputs has a type of its own, whose name nobody wrote.
    pub(super) fn new(service: &str, error: JsonError) -> Self {
        let message = match &*error.problem {
            JsonProblem::Member { name, nearest, known, .. } if error.path.is_empty() => {
                let hint = match nearest {
                    Some(nearest) => format!("did you mean `{nearest}`?"),
                    None if known == "none" => "it takes none".to_owned(),
                    None => format!("it takes {known}"),
                };
                format!("service {service} has no input `{name}`; {hint}")
            }
            JsonProblem::Kind { found, .. } if error.path.is_empty() => {
                format!("service {service} takes its inputs as an object, found {found}")
            }
            _ => error.to_string(),
        };
        let depends = matches!(&*error.problem, JsonProblem::Unselected { .. });
        Self { message, path: error.path, missing: false, depends }
    }

    /// Nothing says what an input is.
    pub(super) fn missing(service: &str, path: String) -> Self {
        let message = format!("service {service} wants input `{path}`, which has no default");
        Self { message, path, missing: true, depends: false }
    }
}
