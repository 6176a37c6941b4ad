//! Deployments: components, connections, calls and activities as one document.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Deserializer, Serialize, de};
use serde_json::{Map, Value};

use crate::{Address, LoadRequest, Place, Policy, is_false};

/// A connection to make, and to make again whenever one side comes back: an in port reads an out
/// port, or a remote (`uses`) calls a service.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ConnectionEntry {
    /// The in port, `component/port` or `component/port/element`, or the remote,
    /// `component/remote`.
    #[serde(rename = "in", deserialize_with = "inport")]
    pub inport: String,
    /// The out port or the service, optionally with its middleware: `shm:demo/position`.
    #[serde(rename = "out", deserialize_with = "outport")]
    pub outport: String,
    /// `latest` (default), `queue:N` or `ring:N`; not for a remote.
    #[serde(default, deserialize_with = "policy_text", skip_serializing_if = "Option::is_none")]
    pub policy: Option<String>,
    /// The middleware; by default chosen from those of the two sides.
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
    /// Name of the service.
    pub service: String,
    /// Inputs by name; those left out take their defaults.
    #[serde(default = "no_inputs", skip_serializing_if = "is_empty")]
    pub inputs: Value,
}

/// The components, connections and requests wanted on one daemon.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(default)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Deployment {
    /// Components to load, in this order unless `after` says otherwise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub component: Vec<LoadRequest>,
    /// Connections to make.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub connection: Vec<ConnectionEntry>,
    /// Services to call, in order, once all connections are made.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub call: Vec<CallEntry>,
    /// Activities to start, in order, after the calls.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub activity: Vec<CallEntry>,
}

impl ConnectionEntry {
    /// The policy; it was validated when the entry was read.
    #[must_use]
    pub fn policy(&self) -> Policy {
        self.policy.as_deref().and_then(|policy| policy.parse().ok()).unwrap_or_default()
    }

    /// Name of the instance that reads the port or calls the service.
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
    /// Text of the deployment file.
    pub text: String,
    /// Name of the file, for messages and relative paths.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub file: PathBuf,
    /// Which daemon of the file this one is; by default the name it was started with.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub daemon: Option<String>,
    /// Remove components and connections that the file does not contain.
    #[serde(default, skip_serializing_if = "is_false")]
    pub prune: bool,
    /// Report the steps without taking them.
    #[serde(default, skip_serializing_if = "is_false")]
    pub dry_run: bool,
    /// Seconds that each connection may wait for its other side.
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
    /// The same as text of a deployment file.
    pub text: String,
}

/// What runs, and its middlewares.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct RunningDeployment {
    /// Name of the default middleware.
    pub backend: String,
    /// Options of middlewares. Only for clients with the right to see them: they may contain keys
    /// and passwords.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    #[cfg_attr(feature = "openapi", schema(value_type = Object))]
    pub backends: BTreeMap<String, Map<String, Value>>,
    /// Components, connections, calls and activities.
    #[serde(flatten)]
    pub runs: Deployment,
}

/// Result of applying a deployment.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Applied {
    /// The steps taken, or to be taken, in order.
    pub steps: Vec<String>,
    /// Whether they were taken; false for a dry run.
    pub applied: bool,
    /// Components and connections that the file does not contain and that were kept.
    #[serde(default)]
    pub beside: Vec<String>,
}
