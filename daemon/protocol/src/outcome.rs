//! How a service ended.

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

/// How a service ended: with `result`, or with `exception` and `detail`. Empty while it runs.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Outcome {
    /// Outputs of the service, by name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<Object>))]
    pub result: Option<Value>,
    /// Full name of the exception.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exception: Option<String>,
    /// Members of the exception; null if it has none.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "told")]
    pub detail: Option<Value>,
}

/// Reads a member that is present as `Some`, even if it is null.
fn told<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Value>, D::Error> {
    Value::deserialize(from).map(Some)
}

impl Outcome {
    /// The end of a service by an exception.
    #[must_use]
    pub fn of_exception(name: &str, detail: Value) -> Self {
        Self { result: None, exception: Some(name.to_owned()), detail: Some(detail) }
    }

    /// Whether the service ended, with a result or an exception.
    #[must_use]
    pub fn ended(&self) -> bool {
        self.result.is_some() || self.exception.is_some()
    }
}
