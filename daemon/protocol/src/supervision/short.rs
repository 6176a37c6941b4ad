//! Times as people write them.

use std::fmt;
use std::time::Duration;

/// `2.5 ms`, `30 s`.
pub(super) struct Short(pub(super) Duration);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.as_secs_f64() {
            0.0 => f.write_str("0"),
            seconds if seconds < 0.1 => write!(f, "{} ms", seconds * 1e3),
            seconds => write!(f, "{seconds} s"),
        }
    }
}
