//! Inputs of a service, and messages for invalid ones in terms of what the user typed.

use std::sync::{Arc, Mutex};

use genom_types::{JsonError, JsonProblem, Record};
use serde_json::Value;

/// Inputs of a request.
#[derive(Debug)]
pub enum Asked {
    /// All inputs.
    Whole(Record),
    /// Some inputs of an attribute; the others keep their present values.
    Partial(Value),
}

/// What inputs that are left out become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rest {
    /// Those of an attribute keep their present values, others take their defaults; one without a
    /// default is an error.
    Kept,
    /// They take their defaults, or zero.
    Zero,
}

/// Result of completing partial inputs, set when the request is executed.
#[derive(Debug, Default)]
pub(super) struct Completed {
    /// All inputs, as they were set.
    pub(super) inputs: Option<Value>,
    pub(super) refused: Option<InputError>,
}

/// The result, shared with the request.
pub(super) type Completion = Arc<Mutex<Completed>>;

/// Invalid inputs. Nothing was sent.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct InputError {
    message: String,
    /// The place in the inputs, such as `goal.x[2]`; empty for the inputs as a whole.
    pub path: String,
    /// An input is missing and has no default.
    pub missing: bool,
    /// Whether the input is valid depends on the present value of a union in the component.
    pub(super) depends: bool,
}

impl InputError {
    /// Words the error in terms of the service: users do not know the record type that holds its
    /// inputs.
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

    /// The error for an input that is missing and has no default.
    pub(super) fn missing(service: &str, path: String) -> Self {
        let message = format!("service {service} wants input `{path}`, which has no default");
        Self { message, path, missing: true, depends: false }
    }
}
