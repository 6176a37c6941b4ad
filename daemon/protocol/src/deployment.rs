//! Deployments: components, connections, calls and activities as one document.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Deserializer, Serialize, de};
use serde_json::{Map, Value};

use crate::{Address, LoadRequest, Place, Policy, is_false};

/// A connection that is to be, and to be kept: an in port reads an out port, or a remote
/// (`uses`) calls a service.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
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
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
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
#[serde(default)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
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
    #[must_use]
    pub fn policy(&self) -> Policy {
        self.policy.as_deref().and_then(|policy| policy.parse().ok()).unwrap_or_default()
    }

    /// Instance that reads, or calls.
    #[must_use]
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
    text.parse::<Address>().map(|_| text).map_err(de::Error::custom)
}

fn outport<'de, D: Deserializer<'de>>(from: D) -> Result<String, D::Error> {
    let text = String::deserialize(from)?;
    text.parse::<Place>().map(|_| text).map_err(de::Error::custom)
}

fn policy_text<'de, D: Deserializer<'de>>(from: D) -> Result<Option<String>, D::Error> {
    let text = String::deserialize(from)?;
    text.parse::<Policy>().map(|_| Some(text)).map_err(de::Error::custom)
}

/// A deployment to apply.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct DeploymentRequest {
    /// The file's text.
    pub text: String,
    /// The file's name, for messages and for relative paths in it.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub file: PathBuf,
    /// Which daemon of the file this is; by default the name the daemon was started with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub daemon: Option<String>,
    /// Take away components and connections that the file does not have.
    #[serde(default, skip_serializing_if = "is_false")]
    pub prune: bool,
    /// Only tell what would be done.
    #[serde(default, skip_serializing_if = "is_false")]
    pub dry_run: bool,
    /// Seconds each connection may wait for its other side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(minimum = 0, maximum = 86400))]
    pub timeout: Option<f64>,
}

/// What runs, as a deployment.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Dumped {
    /// The deployment.
    pub deployment: RunningDeployment,
    /// The same as the text of a file.
    pub text: String,
}

/// What runs, and the middlewares under it.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RunningDeployment {
    /// The default middleware.
    pub backend: String,
    /// Options of middlewares, for those who may know: keys and passwords may stand there.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[cfg_attr(feature = "openapi", schema(value_type = Object))]
    pub backends: BTreeMap<String, Map<String, Value>>,
    /// Components, connections, calls and activities.
    #[serde(flatten)]
    pub runs: Deployment,
}

/// What was done, or would be.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Applied {
    /// The steps, in order.
    pub steps: Vec<String>,
    /// Whether they were taken.
    pub applied: bool,
    /// Components and connections that the file does not have, and that are there still.
    #[serde(default)]
    pub beside: Vec<String>,
}
