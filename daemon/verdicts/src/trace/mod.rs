//! Runs to overruns, as recordings, and as scenarios that `genomctl test` plays.

pub mod recording;
pub mod scenario;

use genom_formal::{Happening, TaskReport};

use crate::found::Ticks;
use crate::told::Told;

/// A run in which a task is at work at its tick.
pub struct Traced<'a> {
    told: &'a Told,
    task: &'a TaskReport,
    happenings: Vec<Happening>,
}

impl<'a> Traced<'a> {
    /// The runs that were found, one for each task of which one is known.
    #[must_use]
    pub fn all(all: &'a [Told]) -> Vec<Self> {
        let mut runs = Vec::new();
        for told in all {
            let (Ticks::Seen(report), Some(times)) = (&told.found.ticks, &told.times) else {
                continue;
            };
            for task in report.tasks.iter().filter(|task| !task.course.is_empty()) {
                let happenings = told.found.system.happenings(times, &task.course);
                runs.push(Self { told, task, happenings });
            }
        }
        runs
    }

    /// When that tick comes.
    fn end(&self) -> u64 {
        self.happenings.last().map_or(0, |last| last.date)
    }
}
