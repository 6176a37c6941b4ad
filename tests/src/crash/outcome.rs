//! The result of ending a daemon at one point.

use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

use super::course::Phase;
use super::watched::Step;

/// The result. Everything is in order if `trouble` and `left` are empty.
#[derive(Debug)]
pub struct Outcome {
    /// What the daemon was doing.
    pub phase: Phase,
    /// Index of the call before which it was ended.
    pub call: usize,
    /// That call; `None` if it was ended after the last one.
    pub step: Option<Step>,
    /// Whether a peer was reading the daemon's port, and continued afterwards.
    pub followed: bool,
    /// Time until its successor was ready; `None` if it never was.
    pub ready: Option<Duration>,
    /// Problems of the successor and the peers.
    pub trouble: Vec<String>,
    /// Files that nobody uses and nobody removed.
    pub left: Vec<PathBuf>,
}

impl Outcome {
    /// Whether there were no problems.
    #[must_use]
    pub fn is_fine(&self) -> bool {
        self.ready.is_some() && self.trouble.is_empty() && self.left.is_empty()
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let step = self.step.as_ref().map_or_else(
            || "after the last call".to_owned(),
            |step| format!("{} of {}", step.call, step.file),
        );
        let followed = if self.followed { "read by a peer" } else { "alone" };
        write!(f, "{:8} {:4} {step:44} {followed:15}", self.phase.name(), self.call)?;
        match self.ready {
            Some(ready) => write!(f, " ready in {:4} ms", ready.as_millis())?,
            None => write!(f, " never ready")?,
        }
        for trouble in &self.trouble {
            write!(f, "; {trouble}")?;
        }
        if !self.left.is_empty() {
            write!(f, "; {} files left: {:?}", self.left.len(), self.left)?;
        }
        Ok(())
    }
}
