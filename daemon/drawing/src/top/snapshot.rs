//! The data of the live table at one moment.

use std::time::{Duration, Instant};

use genom_protocol::{Activity, Component, Port, Status, TaskStatistics};
use serde::Serialize;

/// The state of a daemon at one moment.
#[derive(Debug)]
pub struct Snapshot {
    /// The daemon, for the title.
    pub daemon: String,
    /// Its components.
    pub components: Vec<Seen>,
    /// Their ports.
    pub ports: Vec<Port>,
    /// When the ports were read: rates are computed from two snapshots.
    pub taken: Instant,
}

/// A component, with its tasks and activities.
#[derive(Clone, Debug, Serialize)]
pub struct Seen {
    /// What the daemon says of it.
    #[serde(flatten)]
    pub component: Component,
    /// Its tasks.
    pub tasks: Vec<TaskStatistics>,
    /// Its activities.
    pub log: Vec<Activity>,
}

/// The snapshot as data, for `--json`.
#[derive(Debug, Serialize)]
pub struct Data<'a> {
    components: &'a [Seen],
    ports: &'a [Port],
}

impl Snapshot {
    /// The snapshot as data, for `--json`.
    #[must_use]
    pub fn data(&self) -> Data<'_> {
        Data { components: &self.components, ports: &self.ports }
    }

    /// Tasks, each with the name of its component.
    pub(crate) fn tasks(&self) -> impl Iterator<Item = (&str, &TaskStatistics)> {
        let all = self.components.iter();
        all.flat_map(|one| one.tasks.iter().map(|task| (one.component.name.as_str(), task)))
    }

    /// Activities, each with the name of its component; running ones first.
    pub(crate) fn activities(&self) -> Vec<(&str, &Activity)> {
        let all = self.components.iter();
        fn named(one: &Seen) -> impl Iterator<Item = (&str, &Activity)> {
            one.log.iter().map(|activity| (one.component.name.as_str(), activity))
        }
        let mut all: Vec<_> = all.flat_map(named).collect();
        all.sort_by_key(|(_, activity)| activity.status != Status::Running);
        all
    }

    /// Samples per second through a port since an earlier snapshot.
    #[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
    pub(crate) fn rate(&self, port: &Port, earlier: &Snapshot) -> Option<f64> {
        let before = earlier.ports.iter().find(|other| other.address == port.address)?.traffic?;
        let passed = port.traffic?.samples.checked_sub(before.samples)?;
        let span = self.taken.saturating_duration_since(earlier.taken);
        (span > Duration::ZERO).then(|| passed as f64 / span.as_secs_f64())
    }
}
