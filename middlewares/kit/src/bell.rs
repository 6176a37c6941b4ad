//! Wakes one waiting thread from real-time threads.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

/// A wake-up flag that one thread waits for and any thread may set.
///
/// Ringing neither blocks nor allocates. A ring while nobody waits is kept for the next wait.
///
/// ```
/// use std::time::Duration;
/// use genom_kit::bell::Bell;
///
/// let bell = Bell::default();
/// bell.ring();
/// assert!(bell.wait(Some(Duration::ZERO)), "the ring was kept");
/// assert!(!bell.wait(Some(Duration::ZERO)));
/// ```
#[derive(Debug, Default)]
pub struct Bell {
    rung: AtomicBool,
    /// The waiting thread; known after its first wait.
    listener: OnceLock<Thread>,
}

impl Bell {
    /// Wakes the waiting thread. Makes a system call only if that thread sleeps and was not woken
    /// yet.
    pub fn ring(&self) {
        if !self.rung.swap(true, Ordering::SeqCst)
            && let Some(listener) = self.listener.get()
        {
            listener.unpark();
        }
    }

    /// Waits for a ring, at most `timeout` (`None`: without limit). Returns whether it rang. Only
    /// one thread may call this during the life of the bell.
    pub fn wait(&self, timeout: Option<Duration>) -> bool {
        self.listener.get_or_init(thread::current);
        let end = timeout.map(|timeout| Instant::now() + timeout);
        while !self.rung.swap(false, Ordering::SeqCst) {
            let Some(end) = end else {
                thread::park();
                continue;
            };
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            thread::park_timeout(left);
        }
        true
    }
}
