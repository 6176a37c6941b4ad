//! The bare middleware below a way: `genomd --floor`, which measures it with two processes of its
//! own and no component.

use std::io::{self, Read as _};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use genom_apart::process::end_within;
use serde::{Deserialize, Serialize};

use crate::figures::Figures;

/// How long it may take to end once its input has.
const ENDING: Duration = Duration::from_secs(5);

/// Most values that are sent; fewer are at low rates.
const VALUES: u64 = 1000;

/// What is sent over it: values as large and as frequent as those of a connection.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Load {
    /// Name of the middleware.
    pub backend: String,
    /// Size of a value in bytes.
    pub bytes: u64,
    /// Time between two of them, in nanoseconds.
    pub period: u64,
}

/// What a bare middleware takes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct Floor {
    /// From before the value is passed to the library until the other process has copied it.
    #[serde(flatten)]
    pub hop: Figures,
    /// Values that arrived.
    pub values: u64,
    /// Values that did not.
    pub lost: u64,
}

/// What `genomd --floor` prints.
#[derive(Deserialize)]
struct Printed {
    p50_ns: Option<f64>,
    p99_ns: Option<f64>,
    values: u64,
    lost: u64,
}

/// A measurement under way; ended when dropped.
#[derive(Debug)]
pub struct Measuring(Child);

impl Measuring {
    /// Starts it for about so long, in a directory that nothing else uses.
    ///
    /// # Errors
    /// The program cannot be started.
    pub fn start(genomd: &Path, place: &Path, load: &Load, time: Duration) -> io::Result<Self> {
        let time = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        let values = (time / load.period.max(1)).clamp(20, VALUES);
        let mut command = Command::new(genomd);
        command.arg("--floor").arg(&load.backend).arg(place);
        for number in [load.bytes, load.period, values] {
            command.arg(number.to_string());
        }
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        Ok(Self(command.process_group(0).spawn()?))
    }

    /// The result, if it is there: what was measured, or why nothing was.
    pub fn look(&mut self) -> Option<Result<Floor, String>> {
        let status = match self.0.try_wait() {
            Ok(None) => return None,
            Ok(Some(status)) => status,
            Err(error) => return Some(Err(error.to_string())),
        };
        let (mut out, mut err) = (String::new(), String::new());
        // What it prints fits in a pipe.
        let _ = self.0.stdout.take().map(|mut from| from.read_to_string(&mut out));
        let _ = self.0.stderr.take().map(|mut from| from.read_to_string(&mut err));
        Some(read(&out).ok_or_else(|| match err.lines().last() {
            Some(line) => line.to_owned(),
            None => status.to_string(),
        }))
    }
}

fn read(out: &str) -> Option<Floor> {
    let Printed { p50_ns, p99_ns, values, lost } = serde_json::from_str(out).ok()?;
    let hop = Figures { p50: p50_ns? / 1000.0, p99: p99_ns? / 1000.0 };
    Some(Floor { hop, values, lost })
}

impl Drop for Measuring {
    fn drop(&mut self) {
        // It ends when its input does, and takes its other process and its shared memory along.
        drop(self.0.stdin.take());
        end_within(&mut self.0, ENDING);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_measured_or_what_went_wrong_is_told() {
        let out = r#"{"p50_ns": 1500.0, "p99_ns": 2500.0, "values": 7, "lost": 1}"#;
        let hop = Figures { p50: 1.5, p99: 2.5 };
        assert_eq!(read(out), Some(Floor { hop, values: 7, lost: 1 }));
        assert_eq!(read(r#"{"p50_ns": null, "p99_ns": null, "values": 0, "lost": 9}"#), None);
    }
}
