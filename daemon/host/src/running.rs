//! The foreign code that each thread of the daemon runs. One of the few unsafe modules.
#![allow(unsafe_code)]

use std::cell::Cell;
use std::ptr;
use std::sync::atomic::{AtomicI32, Ordering};

/// Process id of the daemon, once it is recorded, to recognise children that codels fork.
static OWN_PROCESS: AtomicI32 = AtomicI32::new(0);

thread_local! {
    /// Description of the foreign code that this thread runs. Has no destructor, since signal
    /// handlers and exit handlers read it.
    static RUNNING: Cell<*const str> = const { Cell::new(ptr::from_ref("")) };
    /// What it runs for; null if that is not known. As above.
    static DOING: Cell<*const Doing> = const { Cell::new(ptr::null()) };
}

/// What a codel is called for, in words for the report of a crash.
#[derive(Debug, Default)]
pub(crate) struct Doing {
    /// Instance name of its component.
    pub(crate) component: String,
    /// `service NAME` or `task NAME`.
    pub(crate) owner: String,
    /// Number of the activity; 0 for none.
    pub(crate) activity: u32,
    /// Inputs of the service as JSON; empty if they are not kept.
    pub(crate) inputs: String,
}

/// Marks that foreign code runs on this thread, until dropped.
pub(crate) struct Running<'a> {
    outer: *const str,
    doing: *const Doing,
    /// Makes the borrows outlive this value.
    _words: &'a str,
    _doing: Option<&'a Doing>,
}

/// Marks that this thread runs what `words` describe, such as ``codel `servo` of demo.so``.
pub(crate) fn running(words: &str) -> Running<'_> {
    begin(words, None)
}

/// The same of a codel that is called for this.
pub(crate) fn serving<'a>(words: &'a str, doing: &'a Doing) -> Running<'a> {
    begin(words, Some(doing))
}

fn begin<'a>(words: &'a str, doing: Option<&'a Doing>) -> Running<'a> {
    Running {
        outer: RUNNING.replace(ptr::from_ref(words)),
        doing: DOING.replace(doing.map_or(ptr::null(), ptr::from_ref)),
        _words: words,
        _doing: doing,
    }
}

impl Drop for Running<'_> {
    fn drop(&mut self) {
        RUNNING.set(self.outer);
        DOING.set(self.doing);
    }
}

/// Records this process as the daemon's.
pub(crate) fn note_own_process() {
    // SAFETY: it has no preconditions.
    OWN_PROCESS.store(unsafe { libc::getpid() }, Ordering::Release);
}

/// Whether this is the daemon's process, and not a child that a codel forked.
pub(crate) fn is_own_process() -> bool {
    // SAFETY: it has no preconditions.
    let this = unsafe { libc::getpid() };
    this == OWN_PROCESS.load(Ordering::Acquire)
}

/// Whether this thread of the daemon runs a codel, or a constructor of a library.
pub(crate) fn in_codel() -> bool {
    !words().is_empty() && is_own_process()
}

/// Description of the foreign code that this thread runs; empty if there is none. Signal handlers
/// may call it.
pub(crate) fn words<'a>() -> &'a str {
    // SAFETY: the words outlive their `Running`, which removes them when it is dropped.
    unsafe { &*RUNNING.get() }
}

/// What the foreign code of this thread runs for, if that is known. Signal handlers may call it.
pub(crate) fn doing<'a>() -> Option<&'a Doing> {
    // SAFETY: as above, and this thread is the only one that changes it, between two calls.
    unsafe { DOING.get().as_ref() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_that_calls_other_code_runs_again_after_it() {
        assert_eq!(words(), "");
        let outer = running("codel `a`");
        {
            let _inner = running("codel `b`");
            assert_eq!(words(), "codel `b`");
        }
        assert_eq!(words(), "codel `a`");
        drop(outer);
        assert_eq!(words(), "");
    }
}
