//! Waits for conditions by polling, under a watchdog.
//!
//! Between two looks is a pause as long as a look takes: a daemon that answers one question after
//! the other, and the test that asks them, would keep the processors from what is waited for, and
//! from the tests beside it.

use std::fmt::Display;
use std::time::{Duration, Instant};

use crate::WATCHDOG;

/// The shortest and the longest pause between two looks.
const PAUSE: (Duration, Duration) = (Duration::from_millis(1), Duration::from_millis(50));

/// Looks until that gives what is waited for; what it gave last, if time is up before.
fn poll<T>(mut look: impl FnMut() -> T, is_last: impl Fn(&T) -> bool) -> Result<(), T> {
    let end = Instant::now() + WATCHDOG;
    loop {
        let begin = Instant::now();
        let found = look();
        if is_last(&found) {
            return Ok(());
        }
        if Instant::now() >= end {
            return Err(found);
        }
        std::thread::park_timeout(begin.elapsed().clamp(PAUSE.0, PAUSE.1));
    }
}

/// Polls until the condition holds.
///
/// # Panics
/// If it does not hold in time.
#[track_caller]
pub fn until(what: &str, so: impl FnMut() -> bool) {
    if poll(so, |holds| *holds).is_err() {
        panic!("{what}: this does not come to be");
    }
}

/// Polls until the answer is `wanted`.
///
/// # Panics
/// If it stays different.
#[track_caller]
pub fn until_answer<T, W>(wanted: &W, ask: impl FnMut() -> T)
where
    T: PartialEq<W> + Display,
    W: Display + ?Sized,
{
    if let Err(found) = poll(ask, |found| found == wanted) {
        panic!("{found} instead of {wanted}");
    }
}
