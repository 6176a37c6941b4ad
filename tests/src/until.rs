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

/// Looks, and makes a pause unless that gave what is waited for.
fn look<T>(so: &mut impl FnMut() -> T, is_last: impl Fn(&T) -> bool) -> T {
    let begin = Instant::now();
    let found = so();
    if !is_last(&found) {
        std::thread::park_timeout(begin.elapsed().clamp(PAUSE.0, PAUSE.1));
    }
    found
}

/// Polls until the condition holds.
///
/// # Panics
/// If it does not hold in time.
#[track_caller]
pub fn until(what: &str, mut so: impl FnMut() -> bool) {
    let end = Instant::now() + WATCHDOG;
    while !look(&mut so, |holds| *holds) {
        assert!(Instant::now() < end, "{what}: this does not come to be");
    }
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
        let found = look(&mut ask, |found| found == wanted);
        if found == *wanted {
            return;
        }
        assert!(Instant::now() < end, "{found} instead of {wanted}");
    }
}
