//! A parameter of a service, as the daemon describes it.

use serde::Deserialize;
use serde_json::Value;

/// What a service takes or gives under a name.
#[derive(Debug, Deserialize)]
pub(crate) struct Parameter {
    pub(crate) name: String,
    /// `in`, `out` or `inout`.
    pub(crate) direction: String,
    #[serde(rename = "type")]
    pub(crate) ty: String,
    #[serde(default)]
    pub(crate) doc: Option<String>,
    /// Taken when the input is left out.
    #[serde(default)]
    pub(crate) default: Option<Value>,
}
