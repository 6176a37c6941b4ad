//! Inputs of a service that were refused, in the words of who typed them: the record of inputs
//! has a type of its own, whose name nobody wrote.

use genom_types::{JsonError, JsonProblem};

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
