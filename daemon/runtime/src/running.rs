//! Codels that run now, as reported to clients.

use std::fmt;

use genom_description::model::CodelIx;

/// A codel that runs now.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunningCodel {
    /// Name of its C function.
    pub codel: String,
    /// Task or service it belongs to.
    pub owner: String,
    /// The task whose thread runs it; `None` when it serves a request.
    pub task: Option<String>,
    /// Duration of the call so far, in nanoseconds.
    pub for_ns: u64,
    /// Whether it counts as stuck because of that.
    pub stuck: bool,
    /// Its index in the model, and the context that it runs in.
    pub(crate) place: (CodelIx, usize),
    /// Monotonic date of its call; together with the context it identifies the call.
    pub(crate) since: u64,
}

impl RunningCodel {
    /// Identifies this call among all calls of the instance.
    #[must_use]
    pub fn call(&self) -> (usize, u64) {
        (self.place.1, self.since)
    }
}

impl fmt::Display for RunningCodel {
    /// `codel NAME of OWNER, for 12 s`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "codel {} of {}, for {}", self.codel, self.owner, seconds(self.for_ns))
    }
}

/// A duration for people: `12 s`, `3.2 s`.
#[must_use]
#[allow(clippy::cast_precision_loss, reason = "two digits are shown")]
pub fn seconds(ns: u64) -> String {
    match ns {
        0..10_000_000_000 => format!("{:.1} s", ns as f64 / 1e9),
        _ => format!("{} s", ns / 1_000_000_000),
    }
}

/// Codels had to be excluded, but one does not return. The operation was not carried out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{instance} is held up{}", tell(.by.as_deref()))]
pub struct HeldUp {
    /// The instance.
    pub instance: String,
    /// The codel that does not return; `None` when many short codels left no gap.
    pub by: Option<Box<RunningCodel>>,
}

fn tell(by: Option<&RunningCodel>) -> String {
    match by {
        Some(codel) => {
            let (name, owner) = (&codel.codel, &codel.owner);
            format!(": codel {name} of {owner} has been running for {}", seconds(codel.for_ns))
        }
        None => ": its codels leave no moment between them".to_owned(),
    }
}
