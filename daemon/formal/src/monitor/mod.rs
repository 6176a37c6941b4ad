//! Whether rules of supervision can be broken at all, and by which run.
//!
//! What a rule hears is read off the steps of the system; the state of an order or formula goes along
//! with that of the system. What a task does from the return of a codel to its next call is one step:
//! nothing of others comes between.

mod beats;
mod bounded;
mod clocked;
mod cycles;
mod dated;
mod deadline;
mod fires;
mod heard;
mod moment;
mod run;
mod search;
mod step;
mod ticks;
mod waiting;

use std::time::Instant;

use genom_runtime::{Happening, Part, Program, Rule, nanos};

use self::fires::undecided;
pub use self::fires::{Fires, Trace};
use crate::system::System;
use crate::timed::Times;
use genom_timing::Limits;

impl System {
    /// Whether a rule can be broken. `times` are those of codels, or why they are not known.
    #[must_use]
    pub fn fires(&self, rule: &Rule, times: Result<&Times, &str>, limits: &Limits) -> Fires {
        match rule {
            Rule::Order(order) => self.search(&search::Watched::Order(order), limits),
            Rule::Formula(program) => self.formula(program, times, limits),
            Rule::After { codels, first } => {
                let returned = first.iter().map(|ix| Happening::Return(*ix)).collect();
                self.calls_break(
                    codels,
                    limits,
                    vec![
                        Part::Happens(returned),
                        Part::Once(genom_runtime::Bounds { least: 0, most: u64::MAX }, 1),
                        Part::Implies(0, 2),
                    ],
                )
            }
            Rule::During { codels, service } => self.calls_break(
                codels,
                limits,
                vec![Part::Runs(*service), Part::Not(1), Part::Implies(0, 2)],
            ),
            Rule::Step { owner, from, to } => self.takes_step(*owner, (*from, *to), limits),
            Rule::Longest { codels } => self.longest(codels, times, limits),
            Rule::Cycle { task, longest } => self.cycle(*task, *longest, times, limits),
            Rule::Missed { task, ticks, within } => {
                self.missed(*task, (*ticks, *within), times, limits)
            }
            Rule::Stuck { codels } => self.stuck(codels, times, limits),
            Rule::Activity { service, longest } => {
                self.waiting((*service, false), *longest, times, limits)
            }
            Rule::Stop { service, longest } => {
                self.waiting((*service, true), *longest, times, limits)
            }
            Rule::Beat { of, least, longest, during } => {
                let bounds = (nanos(*least), nanos(*longest));
                self.heartbeat(of, bounds, *during, times, limits)
            }
        }
    }

    /// A formula about the calls of these codels, which are its first part.
    fn calls_break(
        &self,
        codels: &[genom_runtime::CodelIx],
        limits: &Limits,
        more: Vec<Part>,
    ) -> Fires {
        let calls = codels.iter().map(|ix| Happening::Call(*ix)).collect();
        let parts = [Part::Happens(calls)].into_iter().chain(more);
        match Program::new(parts.map(|part| (part, String::new())).collect()) {
            // It has no bounds.
            Ok(program) => self.search(&search::Watched::Formula(&program), limits),
            Err(why) => Fires::Undecided(why.to_string()),
        }
    }

    fn formula(&self, program: &Program, times: Result<&Times, &str>, limits: &Limits) -> Fires {
        if !program.has_bounds() {
            return self.search(&search::Watched::Formula(program), limits);
        }
        let begin = Instant::now();
        // Without dates there is less to look at.
        if let Some((how, other)) = bounded::without(program) {
            let fires = self.search(&search::Watched::Formula(&other), limits);
            if bounded::decides(how, &fires) {
                return fires;
            }
        }
        match times {
            Ok(times) => self.dated_search(program, times, &limits.share(begin, 0)),
            Err(why) => undecided(why),
        }
    }
}
