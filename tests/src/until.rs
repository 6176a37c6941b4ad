//! Waits for what comes to be in its own time, by asking again.

use std::fmt::Display;
use std::time::Instant;

use crate::WATCHDOG;

/// Asks again until it is so.
///
/// # Panics
/// It does not come to be.
#[track_caller]
pub fn until(what: &str, mut so: impl FnMut() -> bool) {
    let end = Instant::now() + WATCHDOG;
    while !so() {
        assert!(Instant::now() < end, "{what}: this does not come to be");
    }
}

/// Asks again until the answer is this one.
///
/// # Panics
/// It stays another one.
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
