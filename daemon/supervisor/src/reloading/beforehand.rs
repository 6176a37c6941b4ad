//! In a cell, opens a new library in a process of its own first: one that ends its process while it
//! is loaded is refused, and nothing happens to what runs.

use std::ffi::OsStr;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use super::error::ReloadError;

/// How long a library may take to load.
const TIME: Duration = Duration::from_secs(20);
/// Interval of looking whether it has.
const LOOK: Duration = Duration::from_millis(5);
/// Of what the process said, at most this much is told.
const MOST: u64 = 4096;

/// Loads a library as `genomd --check` does, without calling a codel.
///
/// # Errors
/// The process did not end in order. A library that is only refused is not one: whoever opens it
/// says why.
pub(super) fn load(
    program: &Path,
    library: &Path,
    description: Option<PathBuf>,
    include: &[PathBuf],
) -> Result<(), ReloadError> {
    match end_of(program, library, description, include) {
        Ok(None) => Ok(()),
        Ok(Some(end)) => Err(ReloadError::Crashes { library: library.to_owned(), end }),
        Err(error) => {
            let library = library.display();
            tracing::warn!("{library} is not loaded in another process beforehand: {error}");
            Ok(())
        }
    }
}

/// How the process ended, if that was not in order.
fn end_of(
    program: &Path,
    library: &Path,
    description: Option<PathBuf>,
    include: &[PathBuf],
) -> io::Result<Option<String>> {
    let mut command = Command::new(program);
    command.arg("--check").arg("--log").arg("error");
    command.args(include.iter().flat_map(|one| [OsStr::new("-I"), one.as_os_str()]));
    if let Some(description) = description {
        command.arg("--gen").arg(description);
    }
    command.arg(library).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn()?;
    let said = child.stderr.take();
    let status = wait(&mut child)?;
    let Some(status) = status else { return Ok(Some(format!("not done after {TIME:?}"))) };
    if matches!(status.code(), Some(0 | 1)) {
        return Ok(None);
    }
    let mut text = String::new();
    if let Some(said) = said {
        let _ = said.take(MOST).read_to_string(&mut text);
    }
    Ok(Some(told(status, &text)))
}

/// `None` if it did not end in time; then it is killed.
fn wait(child: &mut Child) -> io::Result<Option<ExitStatus>> {
    let end = Instant::now() + TIME;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        if Instant::now() >= end {
            child.kill()?;
            child.wait()?;
            return Ok(None);
        }
        thread::park_timeout(LOOK);
    }
}

/// The end, with the last line of what the process said.
fn told(status: ExitStatus, said: &str) -> String {
    let last = said.lines().rev().map(str::trim).find(|line| !line.is_empty());
    last.map_or_else(|| status.to_string(), |last| format!("{status}: {last}"))
}
