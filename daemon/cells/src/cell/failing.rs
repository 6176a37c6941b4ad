//! What is done as soon as a process is seen to have ended: other components are told what to do
//! (`on_failure`) before anything else, and before the next process starts.

use std::time::{Duration, Instant};

use rustix::process::Signal;
use tokio::time::timeout;

use super::Cell;
use crate::done::work;
use crate::end::End;
use crate::process::Process;
use crate::setup::{Cause, Failure, Told};

/// How long a start waits for what is done of other components. It takes a few milliseconds; a
/// service that takes longer, or hangs, keeps no cell from coming back.
const REACTING: Duration = Duration::from_millis(50);

impl Cell {
    /// Waits until nothing of its process is left; when that is seen to have ended, has done what is
    /// to be done.
    pub(super) async fn end_of(&self, process: &Process) -> End {
        self.react_to(&process.seen().await);
        process.ended().await
    }

    /// Kills it, and has done what is to be done when it has ended.
    pub(super) async fn kill_for(&self, process: &Process, why: End) -> End {
        process.signal(Signal::KILL);
        process.seen().await;
        self.react_to(&why);
        process.ended().await;
        why
    }

    /// Has done what is to be done of other components for this end, once.
    pub(super) fn react_to(&self, end: &End) {
        if !end.is_failure() || self.is_stopping() || self.with(|state| state.reacting.is_some()) {
            return;
        }
        let seen = Instant::now();
        let (doing, waiting) = work();
        // What is wrong with the journal is told when the next process is to start.
        let held = self.journal.read().unwrap_or_default();
        for component in held.component.iter().filter(|one| !one.on_failure.is_empty()) {
            let (component, reactions) = (component.instance(), component.on_failure.clone());
            let (cause, under_way) = (Cause::Ended, Some(doing.clone()));
            self.setup.tell(Told::Failed(Failure { component, reactions, seen, cause, under_way }));
        }
        self.with(|state| state.reacting = Some(waiting));
    }

    /// Waits until that was done, for a while.
    pub(super) async fn reacted(&self) {
        if let Some(mut waiting) = self.with(|state| state.reacting.take()) {
            let _ = timeout(REACTING, waiting.done()).await;
        }
    }
}
