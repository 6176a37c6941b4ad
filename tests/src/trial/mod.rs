//! Tries one fault where it can be: in a daemon that also runs a well-behaved component ([`own`]),
//! or in a cell of one ([`cell`]); reports what became of it, of the others, and of the next start.

mod cell;
mod own;

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use serde_json::{Value, json};

use crate::crash::{Outcome, Phase, Toll};
use crate::faults::Fault;
use crate::{Daemon, Footprint, Home, component};

/// Where the component with the misbehaving codel runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In the process of its daemon.
    Own,
    /// In a cell.
    Cell,
}

impl Place {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Own, Self::Cell];
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Own => "own",
            Self::Cell => "cell",
        })
    }
}

/// Result of a trial.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What was done: "a codel ...", or where a daemon was ended.
    pub fault: String,
    /// Where: `own`, `cell`, or `daemon` if all of it was ended.
    pub place: String,
    /// Name of the middleware.
    pub backend: String,
    /// Effect on the daemon that was tried.
    pub happened: String,
    /// Effect on the others: number of periods that they missed.
    pub neighbours: String,
    /// When all was back: the next daemon, or the components of the cell with their connections.
    pub back: String,
    /// By how much the memory of the daemon grew.
    pub memory: String,
    /// What was left of the daemon after everything had ended.
    pub left: String,
    /// How this differs from the expected effect; `None` if it does not.
    pub wrong: Option<String>,
}

impl Trial {
    /// As JSON.
    #[must_use]
    pub fn json(&self) -> Value {
        json!({
            "fault": self.fault, "place": self.place, "backend": self.backend,
            "happened": self.happened, "neighbours": self.neighbours, "back": self.back,
            "memory": self.memory, "left_behind": self.left, "wrong": self.wrong,
        })
    }

    /// Tries a fault on a middleware; in a cell, this many times. A step that fails or hangs is
    /// reported in `wrong`.
    #[must_use]
    pub fn of(fault: &Fault, place: Place, backend: &str, times: usize) -> Self {
        let mut trial = Self {
            fault: fault.what.to_owned(),
            place: place.to_string(),
            backend: backend.to_owned(),
            happened: String::new(),
            neighbours: String::new(),
            back: String::new(),
            memory: String::new(),
            left: String::new(),
            wrong: None,
        };
        let tried = catch_unwind(AssertUnwindSafe(|| match place {
            Place::Own => trial.in_own_process(fault),
            Place::Cell => trial.in_a_cell(fault, times),
        }));
        if let Err(panic) = tried {
            let text = panic.downcast_ref::<String>().cloned();
            let text = text.or_else(|| panic.downcast_ref::<&str>().map(|&text| text.to_owned()));
            trial.wrong = Some(text.unwrap_or_else(|| "the trial failed".to_owned()));
        }
        trial
    }

    /// Name of a row about killed daemons.
    #[must_use]
    pub fn killed_in(phase: Phase) -> String {
        format!("SIGKILL in {}", phase.name())
    }

    /// Result for daemons that were killed with SIGKILL while they used shared memory.
    #[must_use]
    pub fn of_killed(toll: &Toll) -> Self {
        let [half, most] = toll.ready().map(|ready| ready.as_millis());
        let wrong: Vec<String> =
            toll.outcomes.iter().filter(|one| !one.is_fine()).map(Outcome::to_string).collect();
        Self {
            fault: Self::killed_in(toll.phase),
            place: "daemon".to_owned(),
            backend: "shm".to_owned(),
            happened: format!("killed before {} of {} calls", toll.outcomes.len(), toll.calls),
            neighbours: format!("in another daemon {}", toll.missed),
            back: format!("next start {half} ms, at most {most} ms"),
            memory: String::new(),
            left: told(&toll.outcomes.iter().flat_map(|one| one.left.clone()).collect::<Vec<_>>()),
            wrong: (!wrong.is_empty()).then(|| wrong.join("\n")),
        }
    }
}

/// A task at 1 kHz, before all others if this is permitted here.
pub const FAST: &str = "[component.tasks.main]\nperiod_ms = 1.0\nreal_time = true\npriority = 10\n";

/// The demo under this name, with such a task, for a configuration.
///
/// # Panics
/// If it cannot be built.
#[must_use]
pub fn task_of_1_khz(name: &str) -> String {
    let demo = component("demo").library;
    format!("[[component]]\nlibrary = {demo:?}\nname = {name:?}\n{FAST}")
}

/// The component of [`daemon_apart`].
pub(crate) const APART: &str = "apart";

/// A daemon that has nothing to do with what is tried, and runs nothing but such a task: what it
/// misses, tasks miss on this machine anyway.
pub(crate) fn daemon_apart() -> Daemon {
    Home::new().configured(&task_of_1_khz(APART)).start(&[])
}

/// Names of files for a cell of the table.
fn told(left: &[PathBuf]) -> String {
    match left {
        [] => "nothing".to_owned(),
        [one] => one.display().to_string(),
        [one, rest @ ..] => format!("{} and {} more", one.display(), rest.len()),
    }
}

/// The exception with which a call ended.
fn exception(said: &str) -> &str {
    let after = said.split_once("ended with ").map_or("", |(_, after)| after);
    after.split_whitespace().next().unwrap_or("?")
}

/// Growth of a daemon's memory.
fn grown(before: &Footprint, now: &Footprint) -> String {
    let kib = |held: &Footprint| i64::try_from(held.resident).unwrap_or(i64::MAX);
    format!("{:+} KiB", kib(now) - kib(before))
}
