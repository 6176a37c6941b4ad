//! Which time components live in.

use serde::{Deserialize, Serialize};

/// Which time components live in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ClockKind {
    /// The machine's monotonic clock.
    #[default]
    Monotonic,
    /// One that stands still until a supervisor steps it: same inputs, same codel calls.
    Virtual,
}
