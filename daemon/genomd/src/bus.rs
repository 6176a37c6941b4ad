//! What changes in the daemon, numbered, for whoever listens; the last ones are kept.
//!
//! Telling never waits: a listener that does not keep up is told that it lost changes.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use serde::Serialize;
use serde_json::Value;
use tokio::sync::broadcast;

use crate::dates::Dates;

/// Something that changed.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub(crate) enum Change {
    /// A component runs.
    ComponentLoaded { component: String, backend: String },
    /// A component stopped and is gone.
    ComponentUnloaded { component: String },
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
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum StepStatus {
    /// It is being taken.
    Begun,
    /// It was taken.
    Done,
}

/// Something told, and its number.
#[derive(Clone, Debug)]
pub(crate) struct Numbered {
    /// From 1, without gaps.
    pub(crate) id: u64,
    /// When it was told.
    pub(crate) date: u64,
    /// What was told, as JSON.
    pub(crate) data: Arc<Value>,
}

/// How much is kept for listeners that come back (`Last-Event-ID`).
const KEPT: usize = 1024;

/// Where changes are told and heard.
#[derive(Debug)]
pub(crate) struct Bus(Numbers);

/// What was told lately, by number, and who listens.
#[derive(Debug)]
pub(crate) struct Numbers {
    dates: Dates,
    past: Mutex<Past>,
    live: broadcast::Sender<Numbered>,
}

#[derive(Debug, Default)]
struct Past {
    last: u64,
    kept: VecDeque<Numbered>,
}

impl Bus {
    /// A bus on which nothing was told yet.
    pub(crate) fn new(dates: Dates) -> Self {
        Self(Numbers::new(dates))
    }

    /// Tells a change to all listeners.
    pub(crate) fn tell(&self, change: &Change) {
        self.0.add(serde_json::to_value(change).unwrap_or_default());
    }

    /// The kept changes after number `after` (none: from now on), and those to come.
    pub(crate) fn listen(
        &self,
        after: Option<u64>,
    ) -> (Vec<Numbered>, broadcast::Receiver<Numbered>) {
        self.0.listen(after)
    }
}

impl Numbers {
    /// Nothing told yet.
    pub(crate) fn new(dates: Dates) -> Self {
        Self { dates, past: Mutex::default(), live: broadcast::Sender::new(KEPT) }
    }

    /// Numbers it and tells it to all listeners.
    pub(crate) fn add(&self, data: Value) {
        let data = Arc::new(data);
        let mut past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        past.last += 1;
        let numbered = Numbered { id: past.last, date: self.dates.now(), data };
        if past.kept.len() == KEPT {
            past.kept.pop_front();
        }
        past.kept.push_back(numbered.clone());
        // Under the lock, so that numbers are heard in order. Nobody listening is no error.
        let _ = self.live.send(numbered);
    }

    /// What is kept after number `after` (none: from now on), and what is to come.
    pub(crate) fn listen(
        &self,
        after: Option<u64>,
    ) -> (Vec<Numbered>, broadcast::Receiver<Numbered>) {
        let past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        let missed = after.map_or_else(Vec::new, |after| {
            // A number that never was is of a daemon before this one: all of this one is news.
            let after = if after > past.last { 0 } else { after };
            past.kept.iter().filter(|change| change.id > after).cloned().collect()
        });
        (missed, self.live.subscribe())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_listener_that_comes_back_misses_nothing() {
        let bus = Bus::new(Dates::default());
        for _ in 0..3 {
            bus.tell(&Change::Stopping {});
        }
        let (missed, mut live) = bus.listen(Some(1));
        assert_eq!(missed.iter().map(|change| change.id).collect::<Vec<_>>(), [2, 3]);
        bus.tell(&Change::Disconnected { inport: "a/b".into() });
        let next = live.try_recv().unwrap();
        assert_eq!(next.id, 4);
        assert_eq!(next.data.to_string(), r#"{"event":"disconnected","in":"a/b"}"#);
        assert!(bus.listen(None).0.is_empty());
        // It heard a daemon that is no more.
        assert_eq!(bus.listen(Some(77)).0.len(), 4);
    }
}
