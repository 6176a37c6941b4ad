//! Outcomes of services, in the form that callers, recordings and spans use.

use genom_protocol as protocol;
use genom_runtime as runtime;
use serde_json::Value;

/// How a service ended, with values as JSON.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// It succeeded, with these outputs.
    Success(Value),
    /// It raised an exception.
    Exception {
        /// Full name, such as `::demo::TOO_FAR_AWAY`.
        name: String,
        /// Members of the exception.
        detail: Value,
    },
}

impl Outcome {
    /// Name of the exception, if there was one.
    pub fn exception(&self) -> Option<&str> {
        match self {
            Outcome::Success(_) => None,
            Outcome::Exception { name, .. } => Some(name),
        }
    }
}

impl From<&runtime::Outcome> for Outcome {
    fn from(outcome: &runtime::Outcome) -> Self {
        match outcome {
            runtime::Outcome::Success(outputs) => Outcome::Success(outputs.to_json()),
            runtime::Outcome::Exception(runtime::Exception { name, detail }) => {
                Outcome::Exception { name: name.clone(), detail: detail.clone() }
            }
        }
    }
}

impl From<Outcome> for protocol::Outcome {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Success(outputs) => Self { result: Some(outputs), ..Self::default() },
            Outcome::Exception { name, detail } => {
                Self { exception: Some(name), detail: Some(detail), ..Self::default() }
            }
        }
    }
}
