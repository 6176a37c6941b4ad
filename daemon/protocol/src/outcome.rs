//! How a service ended.

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

/// How a service ended: `result`, or `exception` and `detail`; nothing while it runs.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Outcome {
    /// Outputs of the service.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Object>))]
    pub result: Option<Value>,
    /// Full name of the exception it ended with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exception: Option<String>,
    /// Members of the exception; null when it has none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "told")]
    pub detail: Option<Value>,
}

/// A member that is there, be it null.
fn told<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Value>, D::Error> {
    Value::deserialize(from).map(Some)
}

impl Outcome {
    /// Whether the service ended, well or not.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.result.is_some() || self.exception.is_some()
    }
}
