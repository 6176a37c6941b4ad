//! Waits for conditions by polling, under a watchdog.

use std::fmt::Display;
use std::time::{Duration, Instant};

use crate::WATCHDOG;

/// Polls until the condition holds.
///
/// # Panics
/// If it does not hold in time.
#[track_caller]
pub fn until(what: &str, mut so: impl FnMut() -> bool) {
    let end = Instant::now() + WATCHDOG;
    while !so() {
        assert!(Instant::now() < end, "{what}: this does not come to be");
    }
}

/// Looks every millisecond until the condition holds: for measurements, where questions without a
/// pause would take a processor, and half of another one for their answers, from what is measured.
///
/// # Panics
/// If it does not hold in time.
#[track_caller]
pub fn until_at_leisure(what: &str, mut so: impl FnMut() -> bool) {
    until(what, || {
        let holds = so();
        if !holds {
            std::thread::park_timeout(Duration::from_millis(1));
        }
        holds
    });
}

/// Polls until the answer is `wanted`.
///
/// # Panics
/// If it stays different.
#[track_caller]
pub fn until_answer<T, W>(wanted: &W, mut ask: impl FnMut() -> T)
where
    T: PartialEq<W> + Display,
    W: Display + ?Sized,
{
    let end = Instant::now() + WATCHDOG;
    loop {
        let found = ask();
        if found == *wanted {
            return;
        }
        assert!(Instant::now() < end, "{found} instead of {wanted}");
    }
}
