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
    /// Taken when the input is left out, but of an attribute.
    #[serde(default)]
    pub(crate) default: Option<Value>,
    /// Of an attribute: what it keeps when the input is left out, as far as the daemon tells.
    #[serde(default)]
    pub(crate) current: Option<Value>,
}
