//! Lets another thread see whether a sending thread is held up.
//!
//! A write of a network's library may wait for seconds, until a reader that stopped is given up. It
//! cannot be known beforehand that it will. So each thread counts what it begins and what it ends,
//! and a watching thread looks at the counts from time to time.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;

/// Counts what one thread begins and ends: odd while it is in the middle of something.
#[derive(Debug)]
pub(crate) struct Busy {
    count: AtomicU64,
    alarm: Arc<Alarm>,
}

/// Wakes the watching thread, which sleeps while nothing is sent.
#[derive(Debug, Default)]
pub(crate) struct Alarm {
    /// Whether it looks from time to time by itself.
    awake: AtomicBool,
    thread: OnceLock<Thread>,
}

/// In the middle of something, until it is dropped.
#[derive(Debug)]
pub(crate) struct Working<'a>(&'a Busy);

impl Busy {
    pub(crate) fn new(alarm: &Arc<Alarm>) -> Self {
        Self { count: AtomicU64::new(0), alarm: Arc::clone(alarm) }
    }

    /// Begins something. Costs a system call only when nothing was sent for long.
    pub(crate) fn begin(&self) -> Working<'_> {
        // The count first, the flag second. The watching thread clears the flag first and looks at
        // the count second: so either this thread wakes it, or it does not go to sleep.
        self.count.fetch_add(1, Ordering::SeqCst);
        if !self.alarm.awake.load(Ordering::SeqCst) {
            self.alarm.wake();
        }
        Working(self)
    }

    pub(crate) fn count(&self) -> u64 {
        self.count.load(Ordering::SeqCst)
    }
}

impl Drop for Working<'_> {
    fn drop(&mut self) {
        self.0.count.fetch_add(1, Ordering::SeqCst);
    }
}

/// Whether a count says that its thread is in the middle of something.
pub(crate) fn is_at_work(count: u64) -> bool {
    !count.is_multiple_of(2)
}

impl Alarm {
    pub(crate) fn wake(&self) {
        if !self.awake.swap(true, Ordering::SeqCst)
            && let Some(thread) = self.thread.get()
        {
            thread.unpark();
        }
    }

    /// Sleeps until something is begun; not at all if `quiet` finds that something was begun
    /// meanwhile. For the watching thread only.
    pub(crate) fn sleep(&self, quiet: impl FnOnce() -> bool) {
        self.thread.get_or_init(std::thread::current);
        self.awake.store(false, Ordering::SeqCst);
        if !quiet() {
            self.awake.store(true, Ordering::SeqCst);
        }
        while !self.awake.load(Ordering::SeqCst) {
            std::thread::park();
        }
    }
}
