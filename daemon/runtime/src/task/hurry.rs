//! A sleep until a date, which a shutdown can interrupt.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::io::Errno;
use rustix::thread::futex;
use rustix::time::Timespec;

/// The thread is not asleep, and nobody asked for a wake-up.
const AWAKE: u32 = 0;
/// A wake-up was asked for that the thread has not taken yet.
const ASKED: u32 = 1;
/// The thread sleeps, or is about to.
const ASLEEP: u32 = 2;

/// A place for one thread to sleep.
#[derive(Debug, Default)]
pub(crate) struct Hurry {
    state: AtomicU32,
}

impl Hurry {
    /// Sleeps until a date of the monotonic clock, or until [`get_up`](Self::get_up); takes one
    /// system call, as `clock_nanosleep` does. Returns whether a wake-up was asked for.
    pub(crate) fn sleep_until(&self, date: u64) -> bool {
        let date = Timespec {
            tv_sec: i64::try_from(date / 1_000_000_000).unwrap_or(i64::MAX),
            tv_nsec: i64::try_from(date % 1_000_000_000).unwrap_or(0),
        };
        let lies_down =
            self.state.compare_exchange(AWAKE, ASLEEP, Ordering::AcqRel, Ordering::Acquire);
        while lies_down.is_ok() && self.state.load(Ordering::Acquire) == ASLEEP {
            let any = NonZeroU32::MAX;
            let flags = futex::Flags::PRIVATE;
            let slept = futex::wait_bitset(&self.state, flags, ASLEEP, Some(&date), any);
            if slept == Err(Errno::TIMEDOUT) {
                break;
            }
        }
        self.state.swap(AWAKE, Ordering::AcqRel) == ASKED
    }

    /// Whether a wake-up was asked for; takes it.
    pub(crate) fn take(&self) -> bool {
        self.state.load(Ordering::Relaxed) == ASKED
            && self.state.swap(AWAKE, Ordering::AcqRel) == ASKED
    }

    /// Ends the current sleep, or else the next one. A system call is made only in the first case.
    pub(crate) fn get_up(&self) {
        if self.state.swap(ASKED, Ordering::AcqRel) == ASLEEP {
            let _ = futex::wake(&self.state, futex::Flags::PRIVATE, 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::monotonic;

    #[test]
    fn a_sleep_ends_at_its_date_and_not_before() {
        let (hurry, date) = (Hurry::default(), monotonic() + 2_000_000);
        assert!(!hurry.sleep_until(date));
        assert!(monotonic() >= date);
    }

    #[test]
    fn a_sleep_of_hours_ends_when_somebody_asks_before_or_meanwhile() {
        let (hurry, hours) = (std::sync::Arc::new(Hurry::default()), monotonic() * 2 + (1 << 45));
        hurry.get_up();
        assert!(hurry.sleep_until(hours) && !hurry.take());
        let asked = std::sync::Arc::clone(&hurry);
        let other = std::thread::spawn(move || asked.get_up());
        assert!(hurry.sleep_until(hours));
        other.join().unwrap();
    }
}
