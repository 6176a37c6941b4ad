//! Libraries that are still in use when they are to be closed. One of the few unsafe modules.
//!
//! Unmapping code that a thread, a timer or a thread's destructor is about to run crashes the
//! daemon. A library stays mapped unless that is excluded: what cannot be inspected counts as a
//! use.
#![allow(unsafe_code)]

use std::ops::Range;

use super::{Code, Library, threads, timers};
use crate::process;

impl Library {
    /// Whether threads, timers or thread-specific data that codels left behind still use the
    /// library's code after the last call. If so, it stays mapped for the rest of the process, and
    /// so must the memory that they may use.
    ///
    /// Its signal handlers are removed. If there is a use, the library's finalisation functions run
    /// first, because they may end it.
    pub(crate) fn is_outlived(&mut self) -> bool {
        // The interpreter, which is never unloaded, has the code.
        if self.is_script() {
            return false;
        }
        let parts = self.mappings.iter().filter(|part| part.executable);
        let code: Vec<_> = parts.map(|part| part.range.clone()).collect();
        let mut uses = self.uses(&code);
        if !uses.is_empty() && self.finish() {
            uses = self.uses(&code);
        }
        if !uses.is_empty() {
            tracing::warn!(
                "{}: {}, so its code and IDS stay in memory; end what it starts in the task's \
                 codel<stop>",
                self.path.display(),
                uses.join(", ")
            );
            if let Code::Linked(handle) = &mut self.code {
                handle.keep();
            }
        }
        !uses.is_empty()
    }

    /// Whether a thread is in its code, or may be.
    pub(crate) fn is_run(&self) -> bool {
        if self.is_script() {
            return false;
        }
        let parts = self.mappings.iter().filter(|part| part.executable);
        let code: Vec<_> = parts.map(|part| part.range.clone()).collect();
        let threads = threads::inside(&code);
        threads.inside > 0 || threads.unseen > 0
    }

    /// What still uses its code; removes signal handlers.
    fn uses(&self, code: &[Range<usize>]) -> Vec<String> {
        let (back, left) = process::take_signals_from(code);
        for name in back {
            let path = self.path.display();
            tracing::warn!("{path}: handled {name}; genomd does again what it did before");
        }
        let mut uses: Vec<_> = left.iter().map(|name| format!("it still handles {name}")).collect();
        let timers = timers::into(code);
        if timers > 0 {
            uses.push(format!("a timer still calls it in a thread ({timers})"));
        }
        if process::ends_threads(code) {
            uses.push("a destructor of it waits for the end of threads".to_owned());
        }
        // Last, when nothing else can start a thread in the library any more.
        let threads = threads::inside(code);
        if threads.inside > 0 {
            uses.push(format!("threads that it started run on ({})", threads.inside));
        }
        if threads.unseen > 0 {
            uses.push(format!("{} threads cannot be looked at and may be in it", threads.unseen));
        }
        uses
    }

    /// Runs the functions that closing would run: they destroy C++ objects, which may own threads.
    /// Closing does not run them again. Returns whether there were any.
    fn finish(&mut self) -> bool {
        let Some(finishers) = self.finishers.take() else { return false };
        let base = self.mappings.iter().map(|part| part.range.start).min();
        let lies = |place: &usize| self.mappings.iter().any(|part| part.range.contains(place));
        let place = |at: u64| Some(base? + usize::try_from(at).ok()?).filter(lies);
        let (Some(first), Some(size)) = (place(finishers.at), place(finishers.size_at)) else {
            return false;
        };
        let Code::Linked(handle) = &self.code else { return false };
        // SAFETY: the ELF file says that the table of these functions, and the word with its size,
        // are there.
        unsafe { handle.finish(first, finishers.count, size) }
        true
    }
}
