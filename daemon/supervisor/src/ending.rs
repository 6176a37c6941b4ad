//! Outcomes of services, in the form that callers, recordings and spans use.

use genom_protocol::Outcome;
use serde_json::Value;

/// How a service ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// It succeeded, with these outputs.
    Done(Value),
    /// It raised an exception.
    Exception {
        /// Full name, such as `::demo::TOO_FAR_AWAY`.
        name: String,
        /// Members of the exception.
        detail: Value,
    },
}

impl Ending {
    /// The outcome as the control plane reports it.
    pub fn told(&self) -> Outcome {
        match self.clone() {
            Ending::Done(outputs) => Outcome { result: Some(outputs), ..Outcome::default() },
            Ending::Exception { name, detail } => {
                Outcome { exception: Some(name), detail: Some(detail), ..Outcome::default() }
            }
        }
    }

    /// Name of the exception, if there was one.
    pub fn exception(&self) -> Option<&str> {
        match self {
            Ending::Done(_) => None,
            Ending::Exception { name, .. } => Some(name),
        }
    }
}
