//! `--trace`: runs to overruns as recordings, and as scenarios that `genomctl test` plays.

mod recording;
mod scenario;

use std::path::{Path, PathBuf};

use genom_formal::{Happening, TaskReport, Ticks};

use super::Told;
use crate::failure::Failure;
use crate::session::Session;

/// A run in which a task is at work at its tick.
pub(super) struct Traced<'a> {
    pub(super) told: &'a Told,
    pub(super) task: &'a TaskReport,
    pub(super) happenings: Vec<Happening>,
}

impl Traced<'_> {
    /// When that tick comes.
    fn end(&self) -> u64 {
        self.happenings.last().map_or(0, |last| last.date)
    }
}

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
    let mut runs = Vec::new();
    for told in all {
        let (Ticks::Seen(report), Some(times)) = (&told.found.ticks, &told.times) else { continue };
        for task in report.tasks.iter().filter(|task| !task.course.is_empty()) {
            let happenings = told.found.system.happenings(times, &task.course);
            runs.push(Traced { told, task, happenings });
        }
    }
    for file in files {
        if runs.is_empty() {
            session.tell(&format!(
                "{}: not written: no run of all tasks is known in which one is late",
                file.display()
            ))?;
            continue;
        }
        if is_recording(file) {
            recording::write(file, &runs[0])?;
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
