//! Lets another thread see whether a sending thread is blocked.
//!
//! A write of a network library may block for seconds, until a stopped reader is given up, and
//! nothing shows that beforehand. Each sending thread therefore counts where a call begins and
//! where it ends, and a watching thread reads the counts periodically.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;

/// Counts the beginnings and ends of one thread's calls; odd while a call is in progress.
#[derive(Debug)]
pub(crate) struct Busy {
    count: AtomicU64,
    alarm: Arc<Alarm>,
}

/// Wakes the watching thread, which sleeps while nothing is sent.
#[derive(Debug, Default)]
pub(crate) struct Alarm {
    /// Whether the watching thread is polling, so that it need not be woken.
    awake: AtomicBool,
    thread: OnceLock<Thread>,
}

/// A call in progress, until this is dropped.
#[derive(Debug)]
pub(crate) struct Working<'a>(&'a Busy);

impl Busy {
    pub(crate) fn new(alarm: &Arc<Alarm>) -> Self {
        Self { count: AtomicU64::new(0), alarm: Arc::clone(alarm) }
    }

    /// Marks the beginning of a call. Makes a system call only if nothing was sent for a while.
    pub(crate) fn begin(&self) -> Working<'_> {
        // This thread increments the count, then reads the flag; the watching thread clears the
        // flag, then reads the count. In either order this thread wakes it, or it does not go to
        // sleep.
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

/// Whether a call is in progress at this count.
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

    /// Sleeps until a call begins. Does not sleep if `quiet` finds that one has begun since. Only
    /// for the watching thread.
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
