//! A recording under way, and how one ended.

use std::fs::File;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::Instant;

use genom_protocol::KeptRecording;
use tokio::sync::watch;

/// A recording that is being made.
#[derive(Debug)]
pub struct Active {
    /// Name of its file.
    pub file: String,
    pub(super) path: PathBuf,
    /// The file, until it is written.
    pub(super) made: Mutex<Option<File>>,
    pub(super) ports: Vec<String>,
    pub(super) since: Instant,
    pub(super) number: OnceLock<u64>,
    pub(super) stage: watch::Sender<Stage>,
    pub(super) messages: AtomicU64,
    pub(super) lost: AtomicU64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub(super) enum Stage {
    Opening,
    Recording,
    Over,
}

/// How one ended.
#[derive(Debug)]
pub(super) struct Ended {
    pub(super) why: String,
    pub(super) lost: u64,
}

impl Active {
    pub(super) fn new(file: String, path: PathBuf, made: File, ports: Vec<String>) -> Self {
        Self {
            file,
            path,
            made: Mutex::new(Some(made)),
            ports,
            since: Instant::now(),
            number: OnceLock::new(),
            stage: watch::Sender::new(Stage::Opening),
            messages: AtomicU64::new(0),
            lost: AtomicU64::new(0),
        }
    }

    /// The number by which the supervisor ends it; `None` while it has not begun.
    #[must_use]
    pub fn number(&self) -> Option<u64> {
        self.number.get().copied()
    }

    /// Waits until it has begun, or is over already.
    pub async fn begun(&self) {
        self.reach(Stage::Recording).await;
    }

    /// Waits until its file has its end.
    pub async fn over(&self) {
        self.reach(Stage::Over).await;
    }

    async fn reach(&self, wanted: Stage) {
        // The sender is here: it is not dropped meanwhile.
        let _ = self.stage.subscribe().wait_for(|stage| *stage >= wanted).await;
    }

    pub(super) fn tell(&self, told: &mut KeptRecording) {
        told.seconds = Some(self.since.elapsed().as_secs_f64());
        told.messages = Some(self.messages.load(Ordering::Relaxed));
        told.lost = Some(self.lost.load(Ordering::Relaxed));
        told.ports.clone_from(&self.ports);
    }
}
