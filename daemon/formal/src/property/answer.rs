//! Whether every request is answered: there is no way into a state from which no answer follows,
//! whatever happens by itself.
//!
//! Yields are taken to be fair: a codel that is called for ever yields each of its events now and
//! then. So a request is answered if an answer can be reached from everywhere by steps that nobody
//! has to ask for. Clients need not do anything, no event needs to come, and no codel needs to fail.

use std::time::Instant;

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use super::followed::{
    Step, after, due, followed, is_answer, is_by_itself, is_endless, is_fine, steps, why,
};
use super::graph::{ends_from, reached};
use super::order::needed;
use super::verdict::{Finding, Verdict, verdict};
use genom_description::model::{Ix as _, ServiceIx};

use crate::action::{Action, Answer};
use crate::codels::small;
use crate::explore::{Limit, Limits};
use crate::machines::Machine;
use crate::pack::{pack, unpacked};
use crate::state::State;
use crate::system::System;
use crate::words::Line;

/// Bytes that tables take for each state and for each step.
const TABLES: usize = 64;
/// States of one part, at most.
const PART: usize = 50_000;

/// Whether all requests are answered.
pub(super) fn answer(system: &System, limits: &Limits) -> Verdict {
    let mut system = system.clone();
    // What a shutdown waits for is another property.
    system.bounds.kill = false;
    let found = Graph::new(&system, &limits.first());
    let Some(limit) = found.limit else { return verdict(found.unanswered(&system)) };
    if by_rules(&system) {
        return Verdict::Holds;
    }
    if let Some(found) = by_parts(&system, limits) {
        return verdict(found);
    }
    if limits.states <= limits.first().states {
        return undecided(limit);
    }
    let found = Graph::new(&system, limits);
    match found.limit {
        Some(limit) => undecided(limit),
        None => verdict(found.unanswered(&system)),
    }
}

fn undecided(limit: Limit) -> Verdict {
    Verdict::Undecided(format!("{limit}: raise the limits, or lower the bounds"))
}

/// Whether all activities end by the rules alone. Ticks come for ever, what is executed returns, and
/// who waits for a node gets it (R5). So an activity that was asked to stop ends if each state after
/// `stop` has a way to an end, none sleeps, and they pause only where ticks end pauses; and one that
/// begins ends if that is so of all its states, or runs until it is asked to. One that is pending
/// waits for some that were asked to.
pub(super) fn by_rules(system: &System) -> bool {
    let activities = system.machines.iter().filter(|machine| machine.service.is_some());
    let mut all = activities.map(|machine| {
        let ends = |from: u16| {
            let mut states = reached(system, machine, from, false);
            states.push(from);
            states.iter().all(|state| {
                let Some(codel) = machine.codel(*state) else { return *state == from };
                let answers = &system.codels[usize::from(codel)].answers;
                let sleeps = answers.iter().any(|answer| matches!(answer, Answer::Sleep(_)));
                !sleeps && ends_from(system, machine, *state, true)
            })
        };
        let waits = |machine: &Machine| {
            let codels = machine.codels.iter().flatten();
            let mut answers = codels.flat_map(|codel| &system.codels[usize::from(*codel)].answers);
            answers.any(|answer| matches!(answer, Answer::Pause(_) | Answer::Sleep(_)))
        };
        let goes_on = is_endless(system, machine) || ends(machine.start);
        let sinks = system.sinks.iter().all(|sink| machine.codel(*sink).is_none());
        let ticks = !system.is_aperiodic(machine.task) || !waits(machine);
        ends(machine.stop) && goes_on && sinks && ticks
    });
    all.all(|ends| ends)
}

/// Requests that are not answered if clients request few services. They are not answered in the whole
/// component either, since nothing that happens by itself is left out.
fn by_parts(system: &System, limits: &Limits) -> Option<Vec<Finding>> {
    let limits = Limits { states: limits.states.min(PART), ..limits.first() };
    let activities = (0..small(system.services.len()))
        .filter(|service| system.services[usize::from(*service)].machine.is_some());
    activities.into_iter().find_map(|service| {
        let interrupts = &system.services[usize::from(service)].interrupts;
        let interrupted = (0..small(interrupts.len())).filter(|o| interrupts[usize::from(*o)]);
        let all = interrupted.take(2).chain([service]);
        let meant: Vec<u16> = all.flat_map(|one| needed(system, one)).collect();
        let part = system.slice(&meant);
        let found = Graph::new(&part, &limits);
        // Of states that were not looked at yet, it is not known where they lead.
        let found = if found.limit.is_none() { found.unanswered(&part) } else { Vec::new() };
        (!found.is_empty()).then_some(found)
    })
}

/// States, of which some follow an activity: its number is kept.
struct Graph {
    states: IndexSet<Box<[u8]>, FxBuildHasher>,
    before: Vec<(u32, Step)>,
    /// Steps that happen by themselves.
    steps: Vec<(u32, u32)>,
    /// States in which the answer comes by a step that happens by itself, or in which none is due.
    answered: Vec<bool>,
    limit: Option<Limit>,
}

impl Graph {
    fn new(system: &System, limits: &Limits) -> Self {
        let begin = Instant::now();
        let mut packed = Vec::new();
        pack(&system.initial(false), &mut packed);
        let first = Step { action: Action::Start, follow: false };
        let mut all = Self {
            states: IndexSet::from_iter([packed.as_slice().into()]),
            before: vec![(0, first)],
            steps: Vec::new(),
            answered: Vec::new(),
            limit: None,
        };
        let mut told = Vec::new();
        while let Some(state) = all.states.get_index(all.answered.len()).map(|b| unpacked(b)) {
            let number = small_index(all.answered.len());
            let followed = followed(&state).is_some();
            all.answered.push(is_fine(system, &state));
            for step in steps(system, &state) {
                told.clear();
                let next = after(system, &state, step, &mut told);
                let by_itself = is_by_itself(system, step.action);
                let answers = followed && told.iter().any(is_answer);
                if by_itself && answers {
                    all.answered[number as usize] = true;
                }
                pack(&next, &mut packed);
                let to = match all.states.get_index_of(packed.as_slice()) {
                    Some(to) => to,
                    None => {
                        all.before.push((number, step));
                        all.states.insert_full(packed.as_slice().into()).0
                    }
                };
                if by_itself && !answers {
                    all.steps.push((number, small_index(to)));
                }
            }
            let bytes = (all.states.len() + all.steps.len() / 4) * TABLES;
            all.limit = limits.passed(all.states.len(), bytes, all.answered.len(), begin);
            if all.limit.is_some() {
                break;
            }
        }
        all
    }

    /// For each service, a state from which no answer to a request of it follows.
    fn unanswered(&self, system: &System) -> Vec<Finding> {
        let count = self.answered.len();
        // Steps by where they lead.
        let mut first = vec![0u32; count + 1];
        self.steps.iter().for_each(|(_, to)| first[*to as usize + 1] += 1);
        for at in 0..count {
            first[at + 1] += first[at];
        }
        let mut from = vec![0u32; self.steps.len()];
        let mut next = first.clone();
        for (before, to) in &self.steps {
            let place = &mut next[*to as usize];
            from[*place as usize] = *before;
            *place += 1;
        }
        let mut answered = self.answered.clone();
        let all = 0..small_index(count);
        let mut left: Vec<u32> = all.filter(|at| answered[*at as usize]).collect();
        while let Some(at) = left.pop() {
            let range = first[at as usize] as usize..first[at as usize + 1] as usize;
            for before in &from[range] {
                if !std::mem::replace(&mut answered[*before as usize], true) {
                    left.push(*before);
                }
            }
        }
        let mut services: Vec<u16> = Vec::new();
        let mut found = Vec::new();
        for (at, _) in answered.iter().enumerate().filter(|(_, answered)| !**answered) {
            let Some(state) = self.states.get_index(at).map(|bytes| unpacked(bytes)) else { break };
            let Some(service) = due(system, &state) else { continue };
            if !services.contains(&service) {
                services.push(service);
                found.push(self.finding(system, (at, &state), service));
            }
        }
        found
    }

    fn finding(&self, system: &System, (at, state): (usize, &State), service: u16) -> Finding {
        let name = system.service_name(service);
        let what =
            format!("a request of {name} may never be answered: {}", why(system, state, service));
        let model = &system.plan.component().services;
        let span = model.get(ServiceIx::new(service.into())).map(|service| service.span);
        Finding { what, span, run: self.lines(system, at) }
    }

    /// A shortest run to a state, in words.
    fn lines(&self, system: &System, number: usize) -> Vec<Line> {
        let (mut lines, mut at) = (Vec::new(), number);
        while at > 0 {
            let (before, step) = self.before[at];
            let Some(state) = self.states.get_index(before as usize) else { break };
            lines.extend(system.words(&unpacked(state), step.action));
            at = before as usize;
        }
        lines.reverse();
        lines
    }
}

fn small_index(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}
