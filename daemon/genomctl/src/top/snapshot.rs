//! Everything the live table shows, at one moment.

use std::time::{Duration, Instant};

use serde::Deserialize;
use serde_json::{Value, json};

use crate::failure::Failure;
use crate::names::url;
use crate::session::Session;

/// A daemon at one moment.
#[derive(Debug)]
pub(crate) struct Snapshot {
    /// Who was asked.
    pub(crate) daemon: String,
    pub(crate) components: Vec<Component>,
    /// Component, then task.
    pub(crate) tasks: Vec<(String, Task)>,
    /// Component, then activity; those that run come first.
    pub(crate) activities: Vec<(String, Activity)>,
    pub(crate) ports: Vec<Port>,
    /// When the ports were asked: rates come from two snapshots.
    pub(crate) taken: Instant,
    /// The daemon's replies, for `--json`.
    pub(crate) data: Value,
}

#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Component {
    pub(crate) name: String,
    /// `running`, or what it is stuck or spins in.
    pub(crate) state: String,
}

#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Task {
    pub(crate) name: String,
    pub(crate) period_ns: Option<u64>,
    pub(crate) real_time: bool,
    pub(crate) cycles: Durations,
    pub(crate) lateness: Durations,
    pub(crate) overruns: u64,
}

#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Durations {
    pub(crate) count: u64,
    pub(crate) mean_ns: u64,
    pub(crate) p99_ns: u64,
    pub(crate) max_ns: u64,
}

#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Activity {
    pub(crate) activity: u64,
    pub(crate) service: String,
    pub(crate) status: String,
    #[serde(default)]
    pub(crate) state: String,
    #[serde(default)]
    pub(crate) exception: Option<String>,
}

#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Port {
    pub(crate) address: String,
    pub(crate) direction: String,
    pub(crate) backend: String,
    #[serde(default)]
    pub(crate) connected: Option<String>,
    #[serde(default)]
    pub(crate) traffic: Option<Traffic>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
pub(crate) struct Traffic {
    pub(crate) samples: u64,
    pub(crate) dropped: u64,
}

impl Snapshot {
    /// Asks the daemon. A component that goes in between is left out.
    pub(crate) async fn take(session: &Session) -> Result<Self, Failure> {
        let mut listed = session.get("/components").await?;
        let components: Vec<Component> = session.read(listed["components"].clone())?;
        let (mut tasks, mut activities) = (Vec::new(), Vec::new());
        for (rank, component) in components.iter().enumerate() {
            let name = component.name.as_str();
            let Ok(mut told) = session.get(&url(["components", name, "tasks"])).await else {
                continue;
            };
            let of_component: Vec<Task> = session.read(told["tasks"].clone())?;
            tasks.extend(of_component.into_iter().map(|task| (name.to_owned(), task)));
            let Ok(mut log) = session.get(&url(["components", name, "activities"])).await else {
                continue;
            };
            let of_component: Vec<Activity> = session.read(log["activities"].clone())?;
            activities.extend(of_component.into_iter().map(|one| (name.to_owned(), one)));
            listed["components"][rank]["tasks"] = told["tasks"].take();
            listed["components"][rank]["log"] = log["activities"].take();
        }
        activities.sort_by_key(|(_, one)| one.status != "running");
        let mut ports = session.get("/ports?values=false").await?;
        let taken = Instant::now();
        Ok(Self {
            daemon: session.client.target(),
            ports: session.read(ports["ports"].clone())?,
            data: json!({"components": listed["components"].take(), "ports": ports["ports"].take()}),
            components,
            tasks,
            activities,
            taken,
        })
    }

    /// Samples a second through a port since an earlier snapshot.
    #[allow(clippy::cast_precision_loss, reason = "a few digits are shown")]
    pub(crate) fn rate(&self, port: &Port, earlier: &Snapshot) -> Option<f64> {
        let before = earlier.ports.iter().find(|other| other.address == port.address)?.traffic?;
        let passed = port.traffic?.samples.checked_sub(before.samples)?;
        let span = self.taken.saturating_duration_since(earlier.taken);
        (span > Duration::ZERO).then(|| passed as f64 / span.as_secs_f64())
    }
}
