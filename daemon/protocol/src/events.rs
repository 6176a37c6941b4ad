//! Changes in the daemon, as `GET /events` reports them.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use strum::VariantNames;

use crate::Kind;

/// `?only=KIND,KIND`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct ChangeParameters {
    /// Report only changes of these kinds, such as `connected,disconnected`. That the daemon stops,
    /// and that changes were missed, is always reported.
    pub only: Option<String>,
}

/// An event was fired.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Fired {
    /// Always true.
    pub fired: bool,
}

/// A change in the daemon.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, VariantNames)]
#[serde(tag = "event", rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[allow(missing_docs, reason = "members are named as everywhere in the control plane")]
pub enum Change {
    /// A component was started.
    ComponentLoaded { component: String, backend: String },
    /// A component was unloaded.
    ComponentUnloaded { component: String },
    /// The library of a running component was exchanged.
    ComponentReloaded { component: String, library: String },
    /// Soon after a reload the process of a component's cell ended, or an activity of it ended with an
    /// exception (`[reload]`): it runs what it ran before.
    ComponentRolledBack { component: String },
    /// The files of a component changed (`watch`), and it runs on as it was.
    ComponentNotReloaded { component: String, why: String },
    /// A component did not stop in time: its name is free, but its threads still run.
    ComponentLeft { component: String, why: String },
    /// A codel has run for so long that it counts as stuck.
    CodelStuck {
        component: String,
        codel: String,
        /// Task or service it belongs to.
        owner: String,
        /// The task whose thread it occupies; absent if the control task runs it for a request.
        #[serde(skip_serializing_if = "Option::is_none")]
        task: Option<String>,
        seconds: f64,
    },
    /// A codel that counted as stuck returned.
    CodelReturned { component: String, codel: String, owner: String, seconds: f64 },
    /// A task occupies a processor and never pauses: a codel yields states again and again.
    CodelSpins {
        component: String,
        codel: String,
        /// Task or service it belongs to.
        owner: String,
        task: String,
        seconds: f64,
    },
    /// A component stopped by itself; the log has the reason.
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
    /// A task missed ticks: it was still running when they came.
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
    /// A step of a deployment.
    DeploymentStep { step: String, status: StepStatus },
    /// A connection of a deployment is waiting for its other side.
    DeploymentWaits { step: String },
    /// The process of a cell runs, or one was found that a daemon before this one had started.
    CellRuns { cell: String, pid: u32, adopted: bool },
    /// The process of a cell ended without being asked to; it is started again when `restarts`.
    CellEnded { cell: String, why: String, components: Vec<String>, restarts: bool },
    /// What is known of that end was written down: `report` names it (`GET /crashes/{crash}`).
    CellCrashed {
        cell: String,
        report: String,
        end: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        codel: Option<String>,
    },
    /// A service ended with an exception that makes a black box write a file.
    ServiceException {
        component: String,
        service: String,
        #[serde(skip_serializing_if = "Option::is_none")]
        activity: Option<u64>,
        exception: String,
    },
    /// A black box wrote what it kept to a file; that of a crash is in its report.
    BlackboxSaved { file: String, why: String, messages: u64 },
    /// A component broke a rule of its supervision. `index` is that of the rule in `supervision` of
    /// its request, `violations` how often it was broken so far; of one rule at most one event a
    /// second.
    SupervisionViolated {
        component: String,
        index: usize,
        /// What must not happen.
        rule: String,
        kind: Kind,
        /// What happened.
        what: String,
        /// The activity that did it; absent if none did.
        #[serde(skip_serializing_if = "Option::is_none")]
        activity: Option<u64>,
        violations: u64,
        /// What is done: `event`, `interrupt`, `restart`, `call base/stop`...
        reactions: Vec<String>,
    },
    /// Something was done since a component failed (`on_failure`) or broke a rule (`supervision`),
    /// or could not be done. `seconds` from the moment that this was seen until the service had
    /// ended, the activity was accepted or the event was fired.
    FailureReaction {
        component: String,
        reaction: String,
        seconds: f64,
        #[serde(skip_serializing_if = "Option::is_none")]
        error: Option<String>,
    },
    /// The daemon is stopping.
    Stopping {},
}

/// Progress of a step of a deployment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum StepStatus {
    /// The step begins.
    Begun,
    /// The step is done.
    Done,
}

/// A change of any kind, including kinds that only later daemons report.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
pub struct AnyChange {
    /// Its kind: one of [`Change`], or `missed` in place of changes that the listener did not
    /// receive.
    pub event: String,
    /// Its other members.
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
