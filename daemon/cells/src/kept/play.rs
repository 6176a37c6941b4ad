//! A replay of a recording: what it publishes, how far it is, and why it ended.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use genom_protocol::KeptReplay;
use genom_recording::ReadError;
use tokio::sync::watch;
use tokio::task::JoinError;

use super::base::lock;

/// Why a replay ended before the last sample.
#[derive(Debug, thiserror::Error)]
pub enum PlayError {
    /// It was asked to.
    #[error("somebody ended it")]
    Stopped,
    /// A sample is so far from the first that no clock gets there.
    #[error("a date beyond all clocks")]
    Date,
    /// A sample could not be published.
    #[error("{0}")]
    Refused(String),
    /// The file cannot be read further.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The thread that reads the file ended.
    #[error(transparent)]
    Reader(#[from] JoinError),
}

/// A topic of a recording that may be published: samples of a port.
#[derive(Clone, Debug)]
pub struct Voice {
    /// Its channel in the file.
    pub channel: u16,
    /// Its topic: `/COMPONENT/PORT`.
    pub topic: String,
    /// The definition of its type.
    pub definition: Vec<u8>,
}

/// A replay, under way or over.
#[derive(Debug)]
pub struct Play {
    pub(super) ports: Vec<String>,
    pub(super) left_out: Vec<String>,
    pub(super) published: AtomicU64,
    pub(super) passed_ns: AtomicU64,
    pub(super) goes_on: watch::Sender<bool>,
    pub(super) stop: watch::Sender<bool>,
    pub(super) problem: Mutex<Option<String>>,
}

impl Play {
    /// Whether it goes on.
    #[must_use]
    pub fn goes_on(&self) -> bool {
        *self.goes_on.borrow()
    }

    /// How it is.
    #[must_use]
    pub fn told(&self) -> KeptReplay {
        KeptReplay {
            goes_on: self.goes_on(),
            ports: self.ports.clone(),
            left_out: self.left_out.clone(),
            published: self.published.load(Ordering::Relaxed),
            seconds: Duration::from_nanos(self.passed_ns.load(Ordering::Relaxed)).as_secs_f64(),
            problem: lock(&self.problem).clone(),
        }
    }

    /// Ends it, and waits until nothing is published any more.
    pub async fn stop(&self) {
        self.stop.send_replace(true);
        let _ = self.goes_on.subscribe().wait_for(|goes_on| !goes_on).await;
    }
}
