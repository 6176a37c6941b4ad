//! Deployments: components, connections, calls and activities as one document.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use serde::{Deserialize, Deserializer, Serialize, de};
use serde_json::{Map, Value};

use crate::on_failure::{is_empty, no_inputs};
use crate::{Address, LoadRequest, Place, Policy, component_of, is_false};

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
    /// The middleware; by default chosen from those of the two sides. An out port of the same daemon
    /// that is not on it is opened there as long as the connection lasts.
    #[serde(default, alias = "backend", skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
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

impl Deployment {
    /// What of it belongs to one process of the daemon: to a cell, or with `None` to the daemon's
    /// own. A component belongs where it says; connections belong to their readers, calls and
    /// activities to their components, of which those that it does not describe are looked up by
    /// `here`. What is to run before a component elsewhere is left to who brings all parts about.
    #[must_use]
    pub fn part(&self, cell: Option<&str>, here: impl Fn(&str) -> bool) -> Self {
        let of = |name: &str| self.component.iter().find(|one| one.instance() == name);
        let mine = |name: &str| {
            of(name).map_or_else(|| here(name), |component| component.cell.as_deref() == cell)
        };
        let mut part = self.clone();
        part.component.retain(|component| component.cell.as_deref() == cell);
        for component in &mut part.component {
            component.after.retain(|name| of(name).is_none() || mine(name));
        }
        part.connection.retain(|entry| mine(entry.reader()));
        part.call.retain(|entry| mine(&entry.component));
        part.activity.retain(|entry| mine(&entry.component));
        part
    }

    /// The cells that it names, each once.
    #[must_use]
    pub fn cells(&self) -> BTreeSet<&str> {
        self.component.iter().filter_map(|component| component.cell.as_deref()).collect()
    }

    /// What is in it together with what is in another; where both name a component or an in port,
    /// this one holds.
    #[must_use]
    pub fn over(mut self, other: &Self) -> Self {
        let (mut component, mut connection) = (other.component.clone(), other.connection.clone());
        component
            .retain(|one| !self.component.iter().any(|mine| mine.instance() == one.instance()));
        connection.retain(|one| !self.connection.iter().any(|mine| mine.inport == one.inport));
        let missing = |mine: &[CallEntry], theirs: &[CallEntry]| {
            let missing = theirs.iter().filter(|one| !mine.contains(one));
            missing.cloned().collect::<Vec<_>>()
        };
        let (call, activity) =
            (missing(&self.call, &other.call), missing(&self.activity, &other.activity));
        self.component.extend(component);
        self.connection.extend(connection);
        self.call.extend(call);
        self.activity.extend(activity);
        self
    }
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
        component_of(&self.inport)
    }
}

impl std::fmt::Display for ConnectionEntry {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} to {}", self.inport, self.outport)
    }
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
    /// Take only what belongs to this cell: as the daemon asks its cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<String>,
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

/// Result of undoing a deployment.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TakenBack {
    /// What could not be undone, a sentence each.
    pub left: Vec<String>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot() -> Deployment {
        let component = |name: &str, cell: Option<&str>, after: &[&str]| LoadRequest {
            name: Some(name.to_owned()),
            cell: cell.map(str::to_owned),
            after: after.iter().map(|&name| name.to_owned()).collect(),
            ..LoadRequest::default()
        };
        let connection = |inport: &str| ConnectionEntry {
            inport: inport.to_owned(),
            outport: "a/out".to_owned(),
            policy: None,
            over: None,
        };
        Deployment {
            component: vec![
                component("a", None, &[]),
                component("b", Some("vision"), &["a", "c"]),
                component("c", Some("vision"), &[]),
            ],
            connection: vec![connection("b/in"), connection("old/in")],
            ..Deployment::default()
        }
    }

    #[test]
    fn each_process_of_a_daemon_has_its_part_of_a_deployment() {
        let names = |of: &Deployment| {
            let names = of.component.iter().map(LoadRequest::instance);
            names.chain(of.connection.iter().map(|one| one.inport.clone())).collect::<Vec<_>>()
        };
        assert_eq!(names(&robot().part(None, |name| name == "old")), ["a", "old/in"]);
        let vision = robot().part(Some("vision"), |_| false);
        assert_eq!(names(&vision), ["b", "c", "b/in"]);
        assert_eq!(vision.component[0].after, ["c"]);
        assert_eq!(robot().cells(), ["vision"].into());
    }

    #[test]
    fn what_is_written_later_holds_over_what_was_there() {
        let mut newer = robot();
        newer.component.truncate(1);
        newer.component[0].restart = crate::RestartPolicy::Always;
        newer.connection.clear();
        let both = newer.over(&robot());
        assert_eq!(both.component.len(), 3);
        assert_eq!(both.component[0].restart, crate::RestartPolicy::Always);
        assert_eq!(both.connection.len(), 2);
    }
}
