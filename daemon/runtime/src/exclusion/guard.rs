//! A lock for very short critical sections, with priority inheritance.

use std::cell::Cell;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use rustix::thread::futex;
use rustix::time::Timespec;

/// Priority-inheriting futex: the word is 0, or the holder's thread id (protocol of the kernel).
#[derive(Debug, Default)]
pub(crate) struct PiLock {
    word: AtomicU32,
}

/// Thread id of this thread in the kernel.
fn this_thread() -> u32 {
    thread_local!(static ID: Cell<u32> = const { Cell::new(0) });
    ID.with(|id| {
        if id.get() == 0 {
            id.set(rustix::thread::gettid().as_raw_nonzero().get().unsigned_abs());
        }
        id.get()
    })
}

impl PiLock {
    pub(crate) fn lock(&self) {
        let me = this_thread();
        while self.word.compare_exchange(0, me, Ordering::Acquire, Ordering::Relaxed).is_err() {
            // Miri does not emulate this futex operation: compare-and-swap only.
            if !cfg!(miri) && futex::lock_pi(&self.word, futex::Flags::PRIVATE, None).is_ok() {
                // The kernel made this thread the holder; acquire what the last one wrote.
                self.word.load(Ordering::Acquire);
                return;
            }
            // Interrupted, or the kernel lacks this call: retry with compare-and-swap.
            std::thread::yield_now();
        }
    }

    /// Locks it if nobody holds it.
    pub(crate) fn try_lock(&self) -> bool {
        self.word.compare_exchange(0, this_thread(), Ordering::Acquire, Ordering::Relaxed).is_ok()
    }

    /// Locks it; `false` when its holder has not unlocked it by then.
    pub(crate) fn lock_until(&self, end: Instant) -> bool {
        while !self.try_lock() {
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            // The kernel takes a date of this clock, and hands the lock over: a holder that locks it
            // again at once finds it taken.
            let date = SystemTime::now() + left;
            let date = date.duration_since(UNIX_EPOCH).ok();
            let date = date.and_then(|date| Timespec::try_from(date).ok());
            let flags = futex::Flags::PRIVATE;
            if !cfg!(miri) && futex::lock_pi(&self.word, flags, date.as_ref()).is_ok() {
                self.word.load(Ordering::Acquire);
                return true;
            }
            std::thread::yield_now();
        }
        true
    }

    pub(crate) fn unlock(&self) {
        let me = this_thread();
        if self.word.compare_exchange(me, 0, Ordering::Release, Ordering::Relaxed).is_err() {
            let _ = futex::unlock_pi(&self.word, futex::Flags::PRIVATE);
        }
    }
}
