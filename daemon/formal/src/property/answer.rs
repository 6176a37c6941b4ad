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
    Step, after_into, due, followed, is_answer, is_by_itself, is_endless, is_fine, steps, why,
};
use super::graph::{ends_from, reached};
use super::order::needed;
use super::verdict::{Finding, Verdict, verdict};
use genom_description::model::{Ix as _, ServiceIx};

use crate::action::{Action, Answer};
use crate::codels::small;
use crate::machines::Machine;
use crate::pack::{pack, unpacked};
use crate::state::State;
use crate::system::System;
use crate::words::Line;
use genom_timing::memory::{ENTRY, listed};
use genom_timing::{Limit, Limits};

/// Bytes that are taken for each state, beside the state itself, and for each step: as they are found,
/// and then as they are followed back.
const TABLES: usize =
    ENTRY + listed::<(u32, Step)>() + listed::<bool>() + 2 * size_of::<u32>() + 1 + listed::<u32>();
const STEP: usize = listed::<(u32, u32)>() + size_of::<u32>();
/// States of one part, at most.
const PART: usize = 200_000;

/// Whether all requests are answered. Of a component that is known to be large not all states are
/// looked at before its rules and its parts.
pub(super) fn answer(system: &System, limits: &Limits, large: bool) -> Verdict {
    let mut system = system.clone();
    // What a shutdown waits for is another property.
    system.bounds.kill = false;
    if !large && let Ok(verdict) = seen(&system, &limits.first()) {
        return verdict;
    }
    if by_rules(&system) {
        return Verdict::Holds;
    }
    if let Some(found) = by_parts(&system, limits) {
        return verdict(found);
    }
    seen(&system, limits).unwrap_or_else(|limit| {
        Verdict::Undecided(format!("{limit}: raise the limits, or lower the bounds"))
    })
}

/// What the states say; the limit if not all were seen, and none of them shows a violation.
fn seen(system: &System, limits: &Limits) -> Result<Verdict, Limit> {
    let graph = Graph::new(system, limits);
    let found = graph.unanswered(system);
    match graph.limit.filter(|_| found.is_empty()) {
        Some(limit) => Err(limit),
        None => Ok(verdict(found)),
    }
}

/// Whether all activities end by the rules alone. Ticks come for ever, what is executed returns, and
/// who waits for a node gets it (R5). So an activity that was asked to stop ends if each state after
/// `stop`, and after an external event, has a way to an end, none sleeps, and none pauses in a task
/// without period. One that begins ends if each of its states has a way to an end without sleep, or
/// runs until it is asked to; while it sleeps no answer is due. One that is pending waits for some
/// that were asked to.
pub(super) fn by_rules(system: &System) -> bool {
    let mut activities = system.machines.iter().filter(|machine| machine.service.is_some());
    activities.all(|machine| ends_by_rules(system, machine))
}

/// Whether the rules alone say so of one activity.
fn ends_by_rules(system: &System, machine: &Machine) -> bool {
    let may = |state: u16, wanted: fn(&Answer) -> bool| {
        let codel = machine.codel(state).map(|codel| &system.codels[usize::from(codel)]);
        codel.is_some_and(|codel| codel.answers.iter().any(wanted))
    };
    let ends = |from: u16| {
        let mut states = reached(system, machine, from, false).into_iter().chain([from]);
        states.all(|state| match machine.codel(state) {
            None => state == from,
            Some(_) => ends_from(system, machine, state, true),
        })
    };
    let sleeps = |from: u16| {
        let mut states = reached(system, machine, from, false).into_iter().chain([from]);
        states.any(|state| may(state, |answer| matches!(answer, Answer::Sleep(_))))
    };
    let waits = |answer: &Answer| matches!(answer, Answer::Pause(_) | Answer::Sleep(_));
    let ticks = !system.is_aperiodic(machine.task)
        || !(0..small(machine.codels.len())).any(|state| may(state, waits));
    let goes_on = is_endless(system, machine) || ends(machine.start);
    let mut later = system.sinks.iter().chain([&machine.stop]);
    ticks && goes_on && later.all(|from| ends(*from) && !sleeps(*from))
}

/// Requests that are not answered if clients request few services. They are not answered in the whole
/// component either, since nothing that happens by itself is left out. First with one activity that
/// nobody stops, then with those that a service interrupts, within the bounds.
fn by_parts(system: &System, limits: &Limits) -> Option<Vec<Finding>> {
    let begin = Instant::now();
    let most = Limits { states: limits.states.min(PART), ..limits.first() };
    let look = |part: System| {
        let found = Graph::new(&part, &most.share(begin, 0)).unanswered(&part);
        (!found.is_empty()).then_some(found)
    };
    // First those of which the rules do not say that they end.
    let (mut first, mut others) = (Vec::new(), Vec::new());
    for (service, facts) in (0u16..).zip(&system.services) {
        let Some(machine) = facts.machine else { continue };
        let ends = ends_by_rules(system, &system.machines[usize::from(machine)]);
        if ends { &mut others } else { &mut first }.push(service);
    }
    first.extend(others);
    let activities = || first.iter().copied();
    let alone = activities().map(|service| {
        let mut part = system.slice(&needed(system, service));
        (part.bounds.instances, part.bounds.requests) = (1, 1);
        (part.bounds.abort, part.bounds.fire) = (false, false);
        part
    });
    let with_others = activities().map(|service| {
        let interrupts = &system.services[usize::from(service)].interrupts;
        let interrupted = (0..small(interrupts.len())).filter(|o| interrupts[usize::from(*o)]);
        let all = interrupted.take(2).chain([service]);
        let meant: Vec<u16> = all.flat_map(|one| needed(system, one)).collect();
        system.slice(&meant)
    });
    alone.chain(with_others).find_map(look)
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
        let (mut packed, mut next) = (Vec::new(), system.initial(false));
        pack(&next, &mut packed);
        let first = Step { action: Action::Start, follow: false };
        let mut all = Self {
            states: IndexSet::from_iter([packed.as_slice().into()]),
            before: vec![(0, first)],
            steps: Vec::new(),
            answered: Vec::new(),
            limit: None,
        };
        let (mut told, mut bytes) = (Vec::new(), 0);
        while let Some(state) = all.states.get_index(all.answered.len()).map(|b| unpacked(b)) {
            let number = small_index(all.answered.len());
            let followed = followed(&state).is_some();
            all.answered.push(is_fine(system, &state));
            for step in steps(system, &state) {
                told.clear();
                after_into(system, &mut next, &state, step, &mut told);
                let by_itself = is_by_itself(system, step.action);
                let answers = followed && told.iter().any(is_answer);
                if by_itself && answers {
                    all.answered[number as usize] = true;
                }
                pack(&next, &mut packed);
                let to = match all.states.get_index_of(packed.as_slice()) {
                    Some(to) => to,
                    None => {
                        bytes += packed.len() + TABLES;
                        all.before.push((number, step));
                        all.states.insert_full(packed.as_slice().into()).0
                    }
                };
                if by_itself && !answers {
                    bytes += STEP;
                    all.steps.push((number, small_index(to)));
                }
            }
            all.limit = limits.passed(all.states.len(), bytes, all.answered.len(), begin);
            if all.limit.is_some() {
                break;
            }
        }
        all
    }

    /// For each service, a state from which no answer to a request of it follows. An answer may
    /// follow from any state that was not looked at; so what is found is so whether all were seen or
    /// not.
    fn unanswered(&self, system: &System) -> Vec<Finding> {
        let count = self.states.len();
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
        answered.resize(count, true);
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
