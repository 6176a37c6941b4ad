//! Tries one fault in a daemon that also runs a well-behaved component, next to another daemon on
//! the same middleware; reports what became of all of them and of the next start.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use serde_json::{Value, json};

use crate::crash::{Outcome, Phase, Toll};
use crate::faults::{self, Fault};
use crate::{Daemon, Finished, Home, Memory, component, path};

/// Result of a trial.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What was done: "a codel ...", or where a daemon was ended.
    pub fault: String,
    /// Name of the middleware.
    pub backend: String,
    /// Effect on the daemon that was tried.
    pub happened: String,
    /// Effect on the others: number of periods that they missed.
    pub neighbours: String,
    /// Result of the next start.
    pub next: String,
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
            "fault": self.fault, "backend": self.backend, "happened": self.happened,
            "neighbours": self.neighbours, "next_start": self.next, "left_behind": self.left,
            "wrong": self.wrong,
        })
    }

    /// Tries a fault on a middleware. A step that fails or hangs is reported in `wrong`.
    #[must_use]
    pub fn of(fault: &Fault, backend: &str) -> Self {
        let mut trial = Self {
            fault: fault.what.to_owned(),
            backend: backend.to_owned(),
            happened: String::new(),
            neighbours: String::new(),
            next: String::new(),
            left: String::new(),
            wrong: None,
        };
        let tried = catch_unwind(AssertUnwindSafe(|| trial.take_place(fault)));
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
            backend: "shm".to_owned(),
            happened: format!("killed before {} of {} calls", toll.outcomes.len(), toll.calls),
            neighbours: format!("in another daemon {}", toll.missed),
            next: format!("ready after {half} ms, at most {most} ms"),
            left: told(&toll.outcomes.iter().flat_map(|one| one.left.clone()).collect::<Vec<_>>()),
            wrong: (!wrong.is_empty()).then(|| wrong.join("\n")),
        }
    }

    fn take_place(&mut self, fault: &Fault) {
        let memory = Arc::new(Memory::new());
        let demo = component("demo");
        let peer = self.daemon(&memory, "peer", path(&demo.library));
        let daemon = self.daemon(&memory, "neighbour", path(&demo.library));
        let (before, peer_before) = (daemon.missed("neighbour"), peer.missed("peer"));
        let seen = fault.provoke(&daemon);
        let (outcome, ended, beside) = if fault.outcome.goes_on() {
            daemon.ctl(&["call", "neighbour", "goto", "goal=0.01"]).expect_code(0);
            let beside = daemon.missed("neighbour") - before;
            daemon.ctl(&["unload", fault.component]).expect_code(0);
            let outcome = match seen.code {
                Some(0) => "goes on".to_owned(),
                _ => format!("ends with {}", exception(&seen.said)),
            };
            let ended = daemon.stop("TERM").0;
            ended.expect_code(0);
            (outcome, ended, Some(beside))
        } else {
            let ended = daemon.finish().0;
            let outcome = match ended.code {
                Some(code) => format!("the daemon ends, exit {code}"),
                None => "the daemon ends by a signal".to_owned(),
            };
            (outcome, ended, None)
        };
        peer.ctl(&["call", "peer", "goto", "goal=0.01"]).expect_code(0);
        let apart = peer.missed("peer") - peer_before;
        let beside = beside.map_or("its daemon's end".to_owned(), |beside| beside.to_string());
        self.neighbours = format!("{beside}; in another daemon {apart}");
        self.happened = outcome;
        self.wrong = wrong(fault, &self.happened, &ended, &seen.said);

        let begin = Instant::now();
        let next = self.daemon(&memory, "neighbour", path(&demo.library));
        self.next = format!("ready after {} ms", begin.elapsed().as_millis());
        next.ctl(&["load", path(&component(fault.component).library)]).expect_code(0);
        next.stop("TERM").0.expect_code(0);
        peer.stop("TERM").0.expect_code(0);
        let left = memory.files();
        self.left = told(&left);
        if !left.is_empty() && self.wrong.is_none() {
            self.wrong = Some(format!("left behind: {left:?}"));
        }
    }

    fn daemon(&self, memory: &Arc<Memory>, name: &str, library: &str) -> Daemon {
        let text = format!(
            "backend = {:?}\n[[component]]\nlibrary = {library:?}\nname = {name:?}\n",
            self.backend
        );
        Home::with(memory).configured(&text).start(&[])
    }
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

/// Differences from the expected effect.
fn wrong(fault: &Fault, happened: &str, ended: &Finished, said: &str) -> Option<String> {
    let fits = match fault.outcome {
        faults::Outcome::GoesOn => happened == "goes on",
        faults::Outcome::Exception(name) => happened == format!("ends with {name}"),
        faults::Outcome::Stops(code) | faults::Outcome::Ends(Some(code)) => {
            ended.code == Some(code)
        }
        faults::Outcome::Ends(None) => ended.code.is_none(),
    };
    if !fits {
        return Some(format!("{happened}; it is to be: {}", fault.outcome));
    }
    let told = ended.err.contains(fault.told) || said.contains(fault.told);
    (!told).then(|| format!("nothing says `{}`", fault.told))
}
