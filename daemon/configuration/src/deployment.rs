//! What a deployment adds to components: connections, calls and activities.

use genom_middleware::{Address, Policy};
use serde::{Deserialize, Deserializer, Serialize, de};
use serde_json::{Map, Value};

use crate::component::LoadRequest;
use crate::place::Place;
use crate::policy;

/// A connection that is to be, and to be kept: an in port reads an out port, or a remote
/// (`uses`) calls a service.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct ConnectionEntry {
    /// The in port, `component/port` or `component/port/element`; or `component/remote`.
    #[serde(rename = "in", deserialize_with = "inport")]
    pub inport: String,
    /// The out port, or the service; with a middleware before it or not.
    #[serde(rename = "out", deserialize_with = "outport")]
    pub outport: String,
    /// `latest`, `queue:N` or `ring:N`; `latest` by default, none for a remote.
    #[serde(default, deserialize_with = "policy_text", skip_serializing_if = "Option::is_none")]
    pub policy: Option<String>,
    /// The middleware, when it is not left to the two sides.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub backend: Option<String>,
}

/// A request to a service.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct CallEntry {
    /// Instance name.
    pub component: String,
    /// Service.
    pub service: String,
    /// Inputs; what is missing takes its default.
    #[serde(default = "no_inputs", skip_serializing_if = "is_empty")]
    pub inputs: Value,
}

/// What is to run and how it is wired, on one daemon.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct Deployment {
    /// Components, in order unless `after` says otherwise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub component: Vec<LoadRequest>,
    /// Connections.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub connection: Vec<ConnectionEntry>,
    /// Services to call, in order, once everything is wired.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub call: Vec<CallEntry>,
    /// Activities to start, in order, after the calls.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub activity: Vec<CallEntry>,
}

impl ConnectionEntry {
    /// The policy; it was checked when the entry was read.
    pub fn policy(&self) -> Policy {
        self.policy.as_deref().and_then(policy::parse).unwrap_or_default()
    }

    /// Instance that reads, or calls.
    pub fn reader(&self) -> &str {
        self.inport.split('/').next().unwrap_or_default()
    }
}

impl std::fmt::Display for ConnectionEntry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} to {}", self.inport, self.outport)
    }
}

fn no_inputs() -> Value {
    Value::Object(Map::new())
}

fn is_empty(inputs: &Value) -> bool {
    inputs.as_object().is_some_and(Map::is_empty)
}

fn inport<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let text = String::deserialize(from)?;
    match Address::parse(&text) {
        Some(_) => Ok(text),
        None => Err(de::Error::custom(format!("`{text}` is no COMPONENT/PORT"))),
    }
}

fn outport<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let text = String::deserialize(from)?;
    Place::parse(&text).map_err(de::Error::custom)?;
    Ok(text)
}

fn policy_text<'de, D: Deserializer<'de>>(from: D) -> Result<Option<String>, D::Error> {
    let text = String::deserialize(from)?;
    match policy::parse(&text) {
        Some(_) => Ok(Some(text)),
        None => Err(de::Error::custom(policy::HELP)),
    }
}
