//! A sleep until a date, which a shutdown can interrupt.

use std::num::NonZeroU32;
use std::sync::atomic::{AtomicU32, Ordering};

use rustix::io::Errno;
use rustix::thread::futex;
use rustix::time::Timespec;

/// A place for one thread to sleep.
#[derive(Debug, Default)]
pub(crate) struct Hurry {
    /// Whether a wake-up was requested that the sleeper has not taken yet.
    asked: AtomicU32,
}

impl Hurry {
    /// Sleeps until a date of the monotonic clock, or until [`get_up`](Self::get_up); takes one
    /// system call, as `clock_nanosleep` does.
    pub(crate) fn sleep_until(&self, date: u64) {
        let date = Timespec {
            tv_sec: i64::try_from(date / 1_000_000_000).unwrap_or(i64::MAX),
            tv_nsec: i64::try_from(date % 1_000_000_000).unwrap_or(0),
        };
        while self.asked.swap(0, Ordering::AcqRel) == 0 {
            let (word, any) = (&self.asked, NonZeroU32::MAX);
            let slept = futex::wait_bitset(word, futex::Flags::PRIVATE, 0, Some(&date), any);
            if slept == Err(Errno::TIMEDOUT) {
                return;
            }
        }
    }

    /// Ends the current sleep, or else the next one.
    pub(crate) fn get_up(&self) {
        self.asked.store(1, Ordering::Release);
        let _ = futex::wake(&self.asked, futex::Flags::PRIVATE, 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clock::monotonic;

    #[test]
    fn a_sleep_ends_at_its_date_and_not_before() {
        let (hurry, date) = (Hurry::default(), monotonic() + 2_000_000);
        hurry.sleep_until(date);
        assert!(monotonic() >= date);
    }

    #[test]
    fn a_sleep_of_hours_ends_when_somebody_asks_before_or_meanwhile() {
        let (hurry, hours) = (std::sync::Arc::new(Hurry::default()), monotonic() * 2 + (1 << 45));
        hurry.get_up();
        hurry.sleep_until(hours);
        let asked = std::sync::Arc::clone(&hurry);
        let other = std::thread::spawn(move || asked.get_up());
        hurry.sleep_until(hours);
        other.join().unwrap();
    }
}
