//! Connects new readers to writers that are idle.
//!
//! iceoryx2 connects a new reader, and sends it the last value, when the writer next publishes.
//! Late readers of a port that is written only once would never get its value. So a thread checks
//! the readers of each of our out ports, and makes the missing connections. It takes no lock of the
//! writer's unless the set of readers changed.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use genom_middleware::{Address, OpenError};

use crate::watch::Watcher;
use crate::writer::Core;

/// Longest time that a late reader in another process waits for the last value of an idle writer,
/// unless another reader leaves at the same time.
pub(crate) const PERIOD: Duration = Duration::from_millis(20);

/// In one of so many rounds it is looked which readers there are; in the others, how many. A reader
/// that comes in the very round in which another one leaves waits for that.
const CLOSELY: u32 = 10;

pub(crate) struct Upkeep {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Default)]
struct State {
    writers: Vec<Arc<Core>>,
    stop: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, watcher: &Watcher) {
        let mut state = self.lock();
        let mut round = 0u32;
        while !state.stop {
            let busy = watcher.busy();
            round = round.wrapping_add(1);
            for writer in &state.writers {
                // `upkeep` reports its errors itself.
                let _ = writer.upkeep(round.is_multiple_of(CLOSELY));
            }
            drop(busy);
            state = if state.writers.is_empty() {
                self.changed.wait(state).unwrap_or_else(PoisonError::into_inner)
            } else {
                let waited = self.changed.wait_timeout(state, PERIOD);
                waited.unwrap_or_else(PoisonError::into_inner).0
            };
        }
    }
}

impl Upkeep {
    pub(crate) fn start(watcher: Watcher) -> Self {
        let shared = Arc::new(Shared::default());
        let own = Arc::clone(&shared);
        let thread =
            thread::Builder::new().name("shm-upkeep".to_owned()).spawn(move || own.run(&watcher));
        if let Err(error) = &thread {
            tracing::error!(%error, "no thread for shm: readers that come late see nothing of idle ports");
        }
        Self { shared, thread: thread.ok() }
    }

    pub(crate) fn add(&self, writer: &Arc<Core>) {
        self.shared.lock().writers.push(Arc::clone(writer));
        self.shared.changed.notify_one();
    }

    /// Removes a writer; the thread holds nothing of it when this returns.
    pub(crate) fn remove(&self, writer: &Arc<Core>) {
        self.shared.lock().writers.retain(|other| !Arc::ptr_eq(other, writer));
    }

    /// Connects a new reader in this daemon at once. Returns whether the writer is in this daemon,
    /// too.
    pub(crate) fn reader_came(&self, at: &Address) -> Result<bool, OpenError> {
        let state = self.shared.lock();
        let Some(writer) = state.writers.iter().find(|writer| writer.is_at(at)) else {
            return Ok(false);
        };
        writer.upkeep(true).map(|()| true)
    }
}

impl Drop for Upkeep {
    fn drop(&mut self) {
        self.shared.lock().stop = true;
        self.shared.changed.notify_one();
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
