//! What came of ending a daemon at one point.

use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

use super::course::Phase;
use super::watched::Step;

/// What came of it; everything in order when `trouble` and `left` are empty.
#[derive(Debug)]
pub struct Outcome {
    /// What the daemon was doing.
    pub phase: Phase,
    /// Which of its calls it never made, from 0.
    pub call: usize,
    /// The call; none when it made all of them, and was ended after the last.
    pub step: Option<Step>,
    /// Whether a peer read the daemon's port, and went on when it was gone.
    pub followed: bool,
    /// Until its successor was ready; none when it never was.
    pub ready: Option<Duration>,
    /// What went wrong with successor and peers.
    pub trouble: Vec<String>,
    /// Files that nobody has and nobody removed.
    pub left: Vec<PathBuf>,
}

impl Outcome {
    /// Whether nobody noticed.
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
