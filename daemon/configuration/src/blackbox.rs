//! Section `[blackbox]`: what is kept of the last seconds, and when it is written.

use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::error::UsageError;
use crate::pattern::matches;
use crate::states::state;

/// Section `[blackbox]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct BlackBoxSection {
    /// Whether anything is kept.
    pub enabled: bool,
    /// Seconds before the reason that are written.
    pub seconds: f64,
    /// Bytes kept of each process: the daemon, and each cell.
    pub bytes: u64,
    /// Most bytes of them of one port.
    pub port_bytes: u64,
    /// Ports, as patterns `COMPONENT/PORT`.
    pub ports: Vec<String>,
    /// Services whose calls and activities are kept, as patterns `COMPONENT/SERVICE`.
    pub services: Vec<String>,
    /// What makes it write a file.
    pub on: Vec<BlackBoxReason>,
    /// Services whose exceptions do, as patterns.
    pub exceptions: Vec<String>,
    /// The directory of the files, but for those of crashes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub directory: Option<PathBuf>,
    /// Files that are kept there; above that, the reason with the most of them loses its oldest.
    pub most: usize,
    /// Size of all of them together, in bytes.
    pub most_bytes: u64,
}

/// What makes a black box write a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BlackBoxReason {
    /// The process of a cell ended without being asked to; the file is part of the report.
    Crash,
    /// A service ended with an exception.
    Exception,
    /// Something that supervision reports: a rule that was broken, a codel that does not return or
    /// never pauses, a component that failed by itself.
    Supervision,
}

impl Default for BlackBoxSection {
    fn default() -> Self {
        let all = || vec!["*".to_owned()];
        Self {
            enabled: false,
            seconds: 10.0,
            bytes: 8_388_608,
            port_bytes: 1_048_576,
            ports: all(),
            services: all(),
            on: vec![BlackBoxReason::Crash],
            exceptions: all(),
            directory: None,
            most: 20,
            most_bytes: 268_435_456,
        }
    }
}

/// Least bytes of a process, and most.
const BYTES: std::ops::RangeInclusive<u64> = 262_144..=1_073_741_824;
/// Longest time, in seconds.
const LONGEST: f64 = 86_400.0;

impl BlackBoxSection {
    /// Checks the numbers and the form of the patterns.
    ///
    /// # Errors
    /// One is none.
    pub fn check(&self) -> Result<(), UsageError> {
        let refuse = |key: &str, value: String, what: &str| {
            let (key, what) = (key.to_owned(), what.to_owned());
            Err(UsageError::BlackBox { key, value, what })
        };
        if !(0.1..=LONGEST).contains(&self.seconds) {
            return refuse("seconds", self.seconds.to_string(), "0.1 to 86400");
        }
        if !BYTES.contains(&self.bytes) {
            return refuse(
                "bytes",
                self.bytes.to_string(),
                "262144 (256 KiB) to 1073741824 (1 GiB)",
            );
        }
        let most = self.bytes / 4;
        if !(4096..=most).contains(&self.port_bytes) {
            let what = format!("4096 to {most}, a quarter of `bytes`");
            return refuse("port_bytes", self.port_bytes.to_string(), &what);
        }
        let lists = [
            ("ports", &self.ports),
            ("services", &self.services),
            ("exceptions", &self.exceptions),
        ];
        for (key, patterns) in lists {
            let wrong = patterns.iter().find(|one| *one != "*" && !one.contains('/'));
            if let Some(wrong) = wrong {
                let what = "write COMPONENT/NAME, with * for anything, such as arm/*";
                return refuse(key, format!("`{wrong}`"), what);
            }
        }
        Ok(())
    }

    /// How far back a file reaches.
    #[must_use]
    pub fn time(&self) -> Duration {
        Duration::try_from_secs_f64(self.seconds).unwrap_or(Duration::from_secs(10))
    }

    /// Whether a file is to be written for this reason.
    #[must_use]
    pub fn is_on(&self, reason: BlackBoxReason) -> bool {
        self.enabled && self.on.contains(&reason)
    }

    /// The directory of the files: the one configured, else `genomd/blackbox` in the user's
    /// directory of states; `None` without any.
    #[must_use]
    pub fn place(&self) -> Option<PathBuf> {
        self.directory.clone().or_else(|| Some(state()?.join("genomd/blackbox")))
    }
}

/// Whether `COMPONENT/NAME`, or `COMPONENT/PORT/ELEMENT` of a multiple port, is one of those that
/// these patterns name.
#[must_use]
pub fn is_one_of(patterns: &[String], address: &str) -> bool {
    let port = address.match_indices('/').nth(1).map(|(at, _)| &address[..at]);
    let named = |pattern: &String| {
        matches(pattern, address) || port.is_some_and(|port| matches(pattern, port))
    };
    patterns.iter().any(named)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pattern_of_a_multiple_port_names_its_elements() {
        let patterns = ["cam/frames".to_owned(), "arm/*".to_owned()];
        for (address, is) in [
            ("cam/frames", true),
            ("cam/frames/left", true),
            ("cam/frame", false),
            ("arm/pose", true),
            ("base/pose", false),
        ] {
            assert_eq!(is_one_of(&patterns, address), is, "{address}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused_by_its_key() {
        let refused = |change: fn(&mut BlackBoxSection)| {
            let mut section = BlackBoxSection::default();
            section.check().unwrap();
            change(&mut section);
            section.check().unwrap_err().to_string()
        };
        let told = refused(|section| section.seconds = f64::NAN);
        assert_eq!(told, "blackbox.seconds = NaN: 0.1 to 86400");
        let told = refused(|section| section.bytes = 1000);
        assert!(told.starts_with("blackbox.bytes = 1000: 262144"), "{told}");
        let told = refused(|section| section.port_bytes = 1 << 30);
        assert!(told.ends_with("2097152, a quarter of `bytes`"), "{told}");
        let told = refused(|section| section.ports = vec!["demo".to_owned()]);
        assert!(told.starts_with("blackbox.ports = `demo`: write COMPONENT/NAME"), "{told}");
    }
}
