//! The data of the live table at one moment.

use std::time::{Duration, Instant};

use genom_protocol::{Activity, Component, Port, PortParameters, Status, TaskStatistics, routes};
use serde::Serialize;

use crate::failure::Failure;
use crate::session::Session;

/// The state of a daemon at one moment.
#[derive(Debug)]
pub(crate) struct Snapshot {
    /// The daemon, for the title.
    pub(crate) daemon: String,
    pub(crate) components: Vec<Seen>,
    pub(crate) ports: Vec<Port>,
    /// When the ports were read: rates are computed from two snapshots.
    pub(crate) taken: Instant,
}

/// A component, with its tasks and activities.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Seen {
    #[serde(flatten)]
    pub(crate) component: Component,
    pub(crate) tasks: Vec<TaskStatistics>,
    /// Its activities.
    pub(crate) log: Vec<Activity>,
}

/// The snapshot as data, for `--json`.
#[derive(Serialize)]
pub(crate) struct Data<'a> {
    components: &'a [Seen],
    ports: &'a [Port],
}

impl Snapshot {
    /// Asks the daemon. A component that is unloaded meanwhile is left out.
    pub(crate) async fn take(session: &Session) -> Result<Self, Failure> {
        let mut components = Vec::new();
        for component in session.ask(routes::components()).await?.content.components {
            let name = component.name.as_str();
            let Ok(statistics) = session.ask(routes::statistics(name)).await else { continue };
            let Ok(activities) = session.ask(routes::activities(name)).await else { continue };
            let (tasks, log) = (statistics.content.tasks, activities.content.activities);
            components.push(Seen { component, tasks, log });
        }
        let query = PortParameters { values: Some(false) };
        let ports = session.ask(routes::ports().with(&query)).await?.content.ports;
        let daemon = session.client.target();
        Ok(Self { daemon, components, ports, taken: Instant::now() })
    }

    /// The snapshot as data, for `--json`.
    pub(crate) fn data(&self) -> Data<'_> {
        Data { components: &self.components, ports: &self.ports }
    }

    /// Tasks, each with the name of its component.
    pub(super) fn tasks(&self) -> impl Iterator<Item = (&str, &TaskStatistics)> {
        let all = self.components.iter();
        all.flat_map(|one| one.tasks.iter().map(|task| (one.component.name.as_str(), task)))
    }

    /// Activities, each with the name of its component; running ones first.
    pub(super) fn activities(&self) -> Vec<(&str, &Activity)> {
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
    pub(super) fn rate(&self, port: &Port, earlier: &Snapshot) -> Option<f64> {
        let before = earlier.ports.iter().find(|other| other.address == port.address)?.traffic?;
        let passed = port.traffic?.samples.checked_sub(before.samples)?;
        let span = self.taken.saturating_duration_since(earlier.taken);
        (span > Duration::ZERO).then(|| passed as f64 / span.as_secs_f64())
    }
}
