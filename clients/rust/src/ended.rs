//! How a daemon ended.

use std::fmt;
use std::fs;
use std::path::Path;
use std::process::ExitStatus;

/// A daemon has ended, or does not answer any more and was killed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ended {
    /// How; `None` if the system does not tell.
    pub status: Option<ExitStatus>,
    /// The error in its log, else the last line there; empty if there is none.
    pub said: String,
}

impl fmt::Display for Ended {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("genomd has ended")?;
        if let Some(status) = self.status {
            write!(f, " ({status})")?;
        }
        if !self.said.is_empty() {
            write!(f, ": {}", self.said)?;
        }
        Ok(())
    }
}

impl std::error::Error for Ended {}

impl Ended {
    /// With what the daemon said in its log.
    pub(crate) fn new(status: Option<ExitStatus>, log: &Path) -> Self {
        let log = String::from_utf8_lossy(&fs::read(log).unwrap_or_default()).into_owned();
        let mut lines = log.lines().map(str::trim).filter(|line| !line.is_empty());
        let error = lines.clone().find_map(|line| line.strip_prefix("error: "));
        Self { status, said: error.or_else(|| lines.next_back()).unwrap_or_default().to_owned() }
    }
}
