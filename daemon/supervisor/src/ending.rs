//! How a service ended: told to callers, recordings and collectors of spans alike.

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

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
    pub fn told(&self) -> Told {
        match self.clone() {
            Ending::Done(outputs) => Told { result: Some(outputs), ..Told::default() },
            Ending::Exception { name, detail } => {
                Told { exception: Some(name), detail: Some(detail), ..Told::default() }
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

/// How a service ended, as a reply: `result`, or `exception` and `detail`.
#[derive(Clone, Debug, Default, Serialize, ToSchema)]
#[schema(as = Ending)]
pub struct Told {
    /// Outputs of the service.
    #[schema(value_type = Option<Object>)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub result: Option<Value>,
    /// Full name of the exception it ended with.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exception: Option<String>,
    /// Members of the exception.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detail: Option<Value>,
}
