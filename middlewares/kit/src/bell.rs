//! Wakes the one thread that waits for work, from real-time threads.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

/// A bell that one thread listens to and any thread may ring.
///
/// Ringing never blocks and never allocates; a ring while nobody waits is kept.
#[derive(Debug, Default)]
pub struct Bell {
    rung: AtomicBool,
    /// The listener, known since it first waited.
    listener: OnceLock<Thread>,
}

impl Bell {
    /// Rings. It costs a system call only when the listener sleeps and was not rung before.
    pub fn ring(&self) {
        if !self.rung.swap(true, Ordering::SeqCst)
            && let Some(listener) = self.listener.get()
        {
            listener.unpark();
        }
    }

    /// Waits for a ring, at most `timeout` if there is one; whether it rang. To be called by one
    /// thread only, for as long as the bell lives.
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
