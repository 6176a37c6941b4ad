//! What components log and how they fare, on its way to a library.
//!
//! Reports come from threads that may not block, so that a thread of the library's own passes them
//! on. What waits for it is limited in number and bytes: beyond, the newest are left out.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};

use genom_kit::complaints::Complaints;
use genom_middleware::{Diagnosis, LogEntry, Part};

use crate::calls::Handle;
use crate::describe::{with_entry, with_parts};

/// Most reports that wait.
const WAITING: usize = 256;

/// Most bytes of all that wait.
const ROOM: usize = 1 << 20;

enum Report {
    Entry(LogEntry),
    Parts(Vec<Diagnosis>),
}

#[derive(Default)]
struct Queue {
    state: Mutex<State>,
    changed: Condvar,
    left_out: Complaints,
}

#[derive(Default)]
struct State {
    reports: VecDeque<(usize, Report)>,
    bytes: usize,
    ends: bool,
}

/// The thread that passes reports on. Ends when this is dropped, after those that wait.
pub(crate) struct Reports {
    library: &'static str,
    queue: Arc<Queue>,
    thread: Option<JoinHandle<()>>,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a report of so many bytes. Returns whether there was room.
    fn put(&self, bytes: usize, report: impl FnOnce() -> Report) -> bool {
        let mut state = self.lock();
        if state.reports.len() >= WAITING || bytes > ROOM - state.bytes {
            return false;
        }
        state.bytes += bytes;
        state.reports.push_back((bytes, report()));
        drop(state);
        self.changed.notify_one();
        true
    }

    /// The next report; `None` once all are passed on and no more come.
    fn next(&self) -> Option<Report> {
        let state = self.lock();
        let waits = |state: &mut State| state.reports.is_empty() && !state.ends;
        let waited = self.changed.wait_while(state, waits);
        let mut state = waited.unwrap_or_else(PoisonError::into_inner);
        let (bytes, report) = state.reports.pop_front()?;
        state.bytes -= bytes;
        Some(report)
    }
}

impl Reports {
    pub(crate) fn start(library: &'static str, to: Arc<Handle>) -> io::Result<Self> {
        let queue = Arc::<Queue>::default();
        let own = Arc::clone(&queue);
        let thread =
            thread::Builder::new().name(format!("{library}-reports")).spawn(move || {
                while let Some(report) = own.next() {
                    match report {
                        Report::Entry(entry) => with_entry(&entry, |entry| to.log(entry)),
                        Report::Parts(parts) => with_parts(&parts, |parts| to.diagnose(parts)),
                    }
                }
            })?;
        Ok(Self { library, queue, thread: Some(thread) })
    }

    pub(crate) fn log(&self, entry: &LogEntry) {
        let texts = [&entry.instance, &entry.place, &entry.file, &entry.message];
        let bytes = texts.map(String::len).iter().sum();
        self.put(bytes, || Report::Entry(entry.clone()));
    }

    pub(crate) fn diagnose(&self, parts: &[Diagnosis]) {
        self.put(parts.iter().map(size).sum(), || Report::Parts(parts.to_vec()));
    }

    fn put(&self, bytes: usize, report: impl FnOnce() -> Report) {
        if !self.queue.put(bytes, report)
            && let Some(count) = self.queue.left_out.add()
        {
            let library = self.library;
            tracing::warn!(
                "{library} is too slow for what it is told of components: {count} reports were left out"
            );
        }
    }
}

/// Bytes of a diagnosis, at least one.
fn size(diagnosis: &Diagnosis) -> usize {
    let Diagnosis { instance, of: Part::Task(name) | Part::Cell(name), message, values, .. } =
        diagnosis;
    let values: usize = values.iter().map(|(name, value)| 1 + name.len() + value.len()).sum();
    1 + instance.len() + name.len() + message.len() + values
}

impl Drop for Reports {
    fn drop(&mut self) {
        self.queue.lock().ends = true;
        self.queue.changed.notify_one();
        let Some(thread) = self.thread.take() else { return };
        // The last end may be closed by what the library does in a report.
        if thread.thread().id() != thread::current().id() {
            // A panic of the thread has been reported already.
            let _ = thread.join();
        }
    }
}
