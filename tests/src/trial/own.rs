//! A fault in the process of its daemon.

use std::sync::Arc;
use std::time::Instant;

use super::{FAST, Trial, exception, grown, told};
use crate::faults::{self, Fault};
use crate::{Daemon, Finished, Footprint, Home, Memory, component, path};

impl Trial {
    /// Next to a component of the same daemon, and one of another.
    pub(super) fn in_own_process(&mut self, fault: &Fault) {
        let memory = Arc::new(Memory::new());
        let demo = component("demo");
        let peer = self.daemon(&memory, "peer", path(&demo.library));
        let daemon = self.daemon(&memory, "neighbour", path(&demo.library));
        let (before, peer_before) = (daemon.missed("neighbour"), peer.missed("peer"));
        let held = Footprint::of(daemon.process().id());
        let seen = fault.provoke(&daemon);
        let (outcome, ended, beside) = if fault.outcome.goes_on() {
            daemon.ctl(&["call", "neighbour", "goto", "goal=0.01"]).expect_code(0);
            let beside = daemon.missed("neighbour") - before;
            daemon.ctl(&["unload", fault.component]).expect_code(0);
            self.memory = grown(&held, &Footprint::of(daemon.process().id()));
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
        self.back = format!("next start {} ms", begin.elapsed().as_millis());
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
            "backend = {:?}\n[[component]]\nlibrary = {library:?}\nname = {name:?}\n{FAST}",
            self.backend
        );
        Home::with(memory).configured(&text).start(&[])
    }
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
