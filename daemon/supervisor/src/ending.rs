//! How a service ended: told to callers, recordings and collectors of spans alike.

use genom_protocol::Outcome;
use serde_json::Value;

/// How a service ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// With these outputs.
    Done(Value),
    /// With an exception and its members.
    Exception {
        /// Full name, such as `::demo::TOO_FAR_AWAY`.
        name: String,
        /// Members of the exception.
        detail: Value,
    },
}

impl Ending {
    /// As a reply.
    pub fn told(&self) -> Outcome {
        match self.clone() {
            Ending::Done(outputs) => Outcome { result: Some(outputs), ..Outcome::default() },
            Ending::Exception { name, detail } => {
                Outcome { exception: Some(name), detail: Some(detail), ..Outcome::default() }
            }
        }
    }

    /// Name of the exception, if it ended with one.
    pub fn exception(&self) -> Option<&str> {
        match self {
            Ending::Done(_) => None,
            Ending::Exception { name, .. } => Some(name),
        }
    }
}
