//! `--trace`: runs to overruns as recordings, and as scenarios that `genomctl test` plays.

use std::path::{Path, PathBuf};

use genom_verdicts::Told;
use genom_verdicts::trace::recording::Unrecorded;
use genom_verdicts::trace::{Traced, recording, scenario};

use crate::failure::Failure;
use crate::session::Session;

/// Where runs are written to, by the ending of the file.
pub(super) fn file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("mcap" | "toml") => Ok(path),
        _ => Err("the file ends in .mcap or .toml".to_owned()),
    }
}

/// Writes the runs that were found.
pub(super) fn write(files: &[PathBuf], all: &[Told], session: &Session) -> Result<(), Failure> {
    let runs = if files.is_empty() { Vec::new() } else { Traced::all(all) };
    for file in files {
        let Some(first) = runs.first() else {
            session.tell(&format!(
                "{}: not written: no run of all tasks is known in which one is late",
                file.display()
            ))?;
            continue;
        };
        if is_recording(file) {
            recording::write(file, first).map_err(|why| match why {
                Unrecorded::File(error) => Failure::file(file, error),
                Unrecorded::Write(error) => Failure::from(error),
            })?;
        } else {
            let text = scenario::text(file, &runs);
            std::fs::write(file, text).map_err(|error| Failure::file(file, error))?;
        }
    }
    Ok(())
}

fn is_recording(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ending == "mcap")
}
