//! What changes in the daemon, as `GET /events` tells it.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use strum::VariantNames;

/// `?only=KIND,KIND`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct ChangeParameters {
    /// Changes of these kinds only, as `connected,disconnected`; that the daemon stops, and that
    /// changes were missed, is told all the same.
    pub only: Option<String>,
}

/// An event was fired.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Fired {
    /// It was.
    pub fired: bool,
}

/// Something that changed.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, VariantNames)]
#[serde(tag = "event", rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[allow(missing_docs, reason = "members are named as everywhere in the control plane")]
pub enum Change {
    /// A component runs.
    ComponentLoaded { component: String, backend: String },
    /// A component stopped and is gone.
    ComponentUnloaded { component: String },
    /// A component did not stop in time: its name is free, and what is left of it cannot go yet.
    ComponentLeft { component: String, why: String },
    /// A codel has been running for so long that it counts as stuck.
    CodelStuck {
        component: String,
        codel: String,
        /// Its task or service.
        owner: String,
        /// The task whose thread it holds; none when it serves a request.
        #[serde(skip_serializing_if = "Option::is_none")]
        task: Option<String>,
        seconds: f64,
    },
    /// A codel that counted as stuck returned, after so long.
    CodelReturned { component: String, codel: String, owner: String, seconds: f64 },
    /// A task keeps a processor and does not pause: a codel yields states again and again.
    CodelSpins {
        component: String,
        codel: String,
        /// Its task or service.
        owner: String,
        task: String,
        seconds: f64,
    },
    /// A component stopped by itself; the reason was logged.
    ComponentFailed { component: String, why: String },
    /// An activity was accepted.
    ActivityStarted { component: String, service: String, activity: u64 },
    /// An activity entered a state.
    Transition { component: String, service: String, activity: u64, state: String, paused: bool },
    /// An activity ended, with outputs or an exception.
    ActivityEnded {
        component: String,
        service: String,
        activity: u64,
        #[serde(skip_serializing_if = "Option::is_none")]
        exception: Option<String>,
    },
    /// Ticks came while a task was still at work.
    Overrun { component: String, task: String, ticks: u64 },
    /// An in port was connected.
    Connected {
        #[serde(rename = "in")]
        inport: String,
        #[serde(rename = "out")]
        outport: String,
        backend: String,
        policy: String,
    },
    /// An in port was disconnected.
    Disconnected {
        #[serde(rename = "in")]
        inport: String,
    },
    /// A component, or one of its ports, moved to other middlewares.
    BackendChanged {
        component: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        port: Option<String>,
        backend: String,
    },
    /// A remote was connected to a service.
    RemoteConnected { remote: String, service: String },
    /// A remote was disconnected.
    RemoteDisconnected { remote: String },
    /// An external event was fired.
    EventFired { component: String, name: String },
    /// A deployment takes a step.
    DeploymentStep { step: String, status: StepStatus },
    /// A connection of a deployment waits for its other side.
    DeploymentWaits { step: String },
    /// The daemon stops.
    Stopping {},
}

/// How far a deployment is with a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum StepStatus {
    /// It is being taken.
    Begun,
    /// It was taken.
    Done,
}

/// A change of any kind, also one that only a later daemon tells.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct AnyChange {
    /// Its kind: a [`Change`], or `missed` in place of changes that the listener did not get.
    pub event: String,
    /// What else it says.
    #[serde(flatten)]
    pub members: Map<String, Value>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_reads_back_as_written_and_a_later_one_is_read_as_any() {
        let change = Change::Disconnected { inport: "a/b".into() };
        let text = serde_json::to_string(&change).unwrap();
        assert_eq!(text, r#"{"event":"disconnected","in":"a/b"}"#);
        assert_eq!(serde_json::from_str::<Change>(&text).unwrap(), change);
        let later = r#"{"event":"rebooted","daemon":"arm"}"#;
        assert!(serde_json::from_str::<Change>(later).is_err());
        let any: AnyChange = serde_json::from_str(later).unwrap();
        assert_eq!((any.event.as_str(), any.members["daemon"].as_str()), ("rebooted", Some("arm")));
    }
}
