//! Whether the threads that send get on with it, for one that watches.
//!
//! What a network's library does takes what time it likes: a write may wait for seconds until a
//! reader that stopped is given up. Nobody is told beforehand, and to be told afterwards is too
//! late; so each thread counts what it begins and ends, and another one looks at the counts.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;

/// What one thread is at: odd while it is in the middle of something.
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
        // Counted first, looked at second; the watching thread does it the other way round before
        // it sleeps: one of the two sees the other.
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

    /// Sleeps until something is begun, unless `quiet` says that something was. By the watching
    /// thread alone.
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
