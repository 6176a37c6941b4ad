//! All states that a component can reach, with the values that clocks can have in each.

use std::time::Instant;

use indexmap::IndexSet;

use super::clocks::{Clock, clocks, guarded, initial, stepped};
use super::times::Times;
use super::zone::Zone;
use crate::action::Action;
use crate::explore::{Limit, Limits};
use crate::pack::{packed, unpacked};
use crate::state::{At, Phase, State};
use crate::system::System;

/// Bytes that tables take for each node.
const TABLES: usize = 48;

/// A state with values of its clocks.
#[derive(Debug)]
struct Node {
    /// The state, by place in the table.
    state: usize,
    zone: Zone,
    /// The node before it, and the number of the step between them.
    before: (u32, u16),
    /// Another node has all its values and more.
    covered: bool,
}

/// States that were reached, with the values of clocks.
#[derive(Debug)]
pub struct Timed {
    states: IndexSet<Box<[u8]>>,
    nodes: Vec<Node>,
    /// Nodes of each state.
    of_state: Vec<Vec<u32>>,
    /// For each task, the first tick that comes while it is at work.
    pub(crate) overruns: Vec<Option<Overrun>>,
    /// For each task, the longest time from a tick to the end of its cycle, in nanoseconds; `None`
    /// inside if there is no bound.
    pub(crate) responses: Vec<Option<Option<u64>>>,
    /// For each task, the end of the longest such cycle.
    pub(crate) slowest: Vec<Option<Overrun>>,
    /// What ended the exploration early.
    pub limit: Option<Limit>,
    /// Time that it took.
    pub took: std::time::Duration,
}

/// A step that a run leads to, such as a tick that comes while its task is at work.
#[derive(Clone, Copy, Debug)]
pub struct Overrun {
    /// The node that it leaves.
    node: u32,
    /// The step.
    action: Action,
}

impl Timed {
    /// Explores the system from its first state on.
    #[must_use]
    pub fn new(system: &System, times: &Times, limits: &Limits) -> Self {
        let begin = Instant::now();
        let tasks = system.periods.len();
        let mut all = Self {
            states: IndexSet::new(),
            nodes: Vec::new(),
            of_state: Vec::new(),
            overruns: vec![None; tasks],
            responses: vec![None; tasks],
            slowest: vec![None; tasks],
            limit: None,
            took: std::time::Duration::ZERO,
        };
        let first = system.initial(false);
        let mut bytes = 0;
        if let Some(zone) = initial(system, times, &first) {
            bytes += all.add(&first, zone, (0, 0));
        }
        let (mut at, mut told) = (0, Vec::new());
        while let Some(node) = all.nodes.get(at) {
            let number = u32::try_from(at).unwrap_or(u32::MAX);
            at += 1;
            if node.covered {
                continue;
            }
            let Some(state) = all.states.get_index(node.state).map(|bytes| unpacked(bytes)) else {
                break;
            };
            let zone = node.zone.clone();
            for (action, step) in system.timed(&state).iter().zip(0u16..) {
                let Some(before) = guarded(system, times, &state, &zone, *action) else {
                    continue;
                };
                let next = system.after(&state, *action, &mut told);
                told.clear();
                all.note(system, times, (number, &state, &before), *action, &next);
                if let Some(after) = stepped(system, times, (&state, &before), *action, &next) {
                    bytes += all.add(&next, after, (number, step));
                }
            }
            all.limit = limits.passed(all.nodes.len(), bytes, at, begin);
            if all.limit.is_some() {
                break;
            }
        }
        all.took = begin.elapsed();
        all
    }

    /// Adds a node unless another one has all its values; returns the bytes that it takes.
    fn add(&mut self, state: &State, zone: Zone, before: (u32, u16)) -> usize {
        let (place, is_new) = self.states.insert_full(packed(state));
        if is_new {
            self.of_state.push(Vec::new());
        }
        let known = &self.of_state[place];
        if known.iter().any(|node| self.nodes[*node as usize].zone.includes(&zone)) {
            return 0;
        }
        let nodes = &mut self.nodes;
        self.of_state[place].retain(|node| {
            let node = &mut nodes[*node as usize];
            node.covered = zone.includes(&node.zone);
            !node.covered
        });
        let number = u32::try_from(nodes.len()).unwrap_or(u32::MAX);
        self.of_state[place].push(number);
        let bytes = zone.bytes() + TABLES + if is_new { packed(state).len() } else { 0 };
        self.nodes.push(Node { state: place, zone, before, covered: false });
        bytes
    }

    /// Whether a step is a tick that comes while its task is at work.
    pub(crate) fn is_late(state: &State, action: Action) -> Option<u16> {
        let Action::Tick(task) = action else { return None };
        let was = &state.tasks[usize::from(task)];
        let works = !matches!(was.at, At::Absent | At::Sleep) && was.young == 0;
        (works && state.phase == Phase::Running).then_some(task)
    }

    /// Notes overruns, and how long cycles take.
    fn note(
        &mut self,
        system: &System,
        times: &Times,
        (number, state, zone): (u32, &State, &Zone),
        action: Action,
        next: &State,
    ) {
        for (task, (was, is)) in state.tasks.iter().zip(&next.tasks).enumerate() {
            let works = !matches!(was.at, At::Absent | At::Sleep) && was.young == 0;
            let ticks = matches!(action, Action::Tick(other) if usize::from(other) == task);
            let works = works && state.phase == Phase::Running;
            if works && ticks {
                self.overruns[task].get_or_insert(Overrun { node: number, action });
            }
            if works && is.at == At::Sleep && system.periods[task].is_some() {
                let clocks = clocks(system, times, state);
                let own = |clock: &Clock| matches!(clock, Clock::Tick(other) if usize::from(*other) == task);
                let at = clocks.iter().position(own).map_or(0, |at| at + 1);
                let most = zone.most(at).and_then(|most| u64::try_from(most).ok());
                let longest = &mut self.responses[task];
                if most.is_none() || longest.flatten().is_none_or(|before| most > Some(before)) {
                    self.slowest[task] = Some(Overrun { node: number, action });
                }
                *longest = Some(match (*longest, most) {
                    (Some(None), _) | (_, None) => None,
                    (Some(Some(before)), Some(most)) => Some(before.max(most)),
                    (None, Some(most)) => Some(most),
                });
            }
        }
    }

    /// Number of states, without values of clocks.
    #[must_use]
    pub fn states(&self) -> usize {
        self.states.len()
    }

    /// The states, in the order in which they were found.
    pub(crate) fn all(&self) -> impl Iterator<Item = State> + '_ {
        self.states.iter().map(|bytes| unpacked(bytes))
    }

    /// Number of zones: those that no other one includes.
    #[must_use]
    pub fn zones(&self) -> usize {
        self.of_state.iter().map(Vec::len).sum()
    }

    /// A run to an overrun: each state, and the step that leaves it.
    pub(crate) fn run_to(&self, system: &System, overrun: Overrun) -> Vec<(State, Action)> {
        let state = |node: u32| {
            let node = self.nodes.get(node as usize)?;
            self.states.get_index(node.state).map(|bytes| unpacked(bytes))
        };
        let mut steps: Vec<(State, Action)> =
            state(overrun.node).map(|state| (state, overrun.action)).into_iter().collect();
        let mut at = overrun.node;
        while at > 0 {
            let Some(node) = self.nodes.get(at as usize) else { break };
            let (before, step) = node.before;
            let Some(from) = state(before) else { break };
            if let Some(action) = system.timed(&from).get(usize::from(step)) {
                steps.push((from, *action));
            }
            at = before;
        }
        steps.reverse();
        steps
    }
}

impl System {
    /// Steps that are possible in a state if its clocks allow them: ticks come at work as well.
    pub(crate) fn timed(&self, state: &State) -> Vec<Action> {
        let mut actions = self.internal(state);
        actions.extend(self.hurries(state));
        actions.extend(self.returns(state));
        if state.phase != Phase::Stopped {
            let periodic = self.periods.iter().zip(0..).filter(|(period, _)| period.is_some());
            actions.extend(periodic.map(|(_, task)| Action::Tick(task)));
        }
        actions.extend(self.asked(state));
        actions
    }
}
