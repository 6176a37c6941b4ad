//! All states that a component can reach, with the values that clocks can have in each.

use std::time::Instant;

use super::clocks::{Clock, clocks, guarded, initial, stepped};
use super::table::Table;
use super::times::Times;
use crate::action::Action;
use crate::state::{At, Phase, State};
use crate::system::System;
use genom_timing::{Limit, Limits, Zone};

/// States that were reached, with the values of clocks.
#[derive(Debug)]
pub struct Timed {
    table: Table,
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
        Self::until(system, times, limits, None)
    }

    /// The same, until this task is late.
    pub(crate) fn until(
        system: &System,
        times: &Times,
        limits: &Limits,
        late: Option<usize>,
    ) -> Self {
        let begin = Instant::now();
        let tasks = system.periods.len();
        let mut all = Self {
            table: Table::default(),
            overruns: vec![None; tasks],
            responses: vec![None; tasks],
            slowest: vec![None; tasks],
            limit: None,
            took: std::time::Duration::ZERO,
        };
        let first = system.initial(false);
        if let Some(zone) = initial(system, times, &first) {
            all.table.add(&first, zone, (0, 0));
        }
        let (mut at, mut told, mut next) = (0u32, Vec::new(), first);
        while (at as usize) < all.table.len() {
            let number = at;
            at += 1;
            let Some((state, zone)) = all.table.get(number) else { continue };
            let zone = zone.clone();
            let before = clocks(system, times, &state);
            for (action, step) in system.timed(&state).iter().zip(0u16..) {
                let Some(possible) = guarded(system, times, (&state, &before), &zone, *action)
                else {
                    continue;
                };
                system.after_into(&mut next, &state, *action, &mut told);
                told.clear();
                all.note(system, number, (&state, &before, &possible), *action, &next);
                let after = clocks(system, times, &next);
                let from = (&before[..], &*possible);
                if let Some(zone) = stepped(system, times, from, *action, (&next, &after)) {
                    all.table.add(&next, zone, (number, step));
                }
            }
            all.limit = limits.passed(all.table.len(), all.table.bytes(), at as usize, begin);
            let done = late.is_some_and(|late| all.overruns[late].is_some());
            if done || all.limit.is_some() {
                break;
            }
        }
        all.took = begin.elapsed();
        all
    }

    /// Whether a step is a tick that comes while its task is at work.
    pub(crate) fn is_late(state: &State, action: Action) -> Option<u16> {
        let Action::Tick(task) = action else { return None };
        works(state, usize::from(task)).then_some(task)
    }

    /// Notes overruns, and how long cycles take.
    fn note(
        &mut self,
        system: &System,
        number: u32,
        (state, clocks, zone): (&State, &[Clock], &Zone),
        action: Action,
        next: &State,
    ) {
        if let Some(task) = Self::is_late(state, action) {
            let overrun = Overrun { node: number, action };
            self.overruns[usize::from(task)].get_or_insert(overrun);
        }
        for (task, is) in (0..).zip(&next.tasks) {
            let index = usize::from(task);
            let ends = is.at == At::Sleep && works(state, index) && system.ticks_of(task);
            if !ends {
                continue;
            }
            let at = clocks.iter().position(|clock| *clock == Clock::Tick(task));
            let most = zone.most(at.map_or(0, |at| at + 1));
            let most = most.and_then(|most| u64::try_from(most).ok());
            let longest = &mut self.responses[index];
            if most.is_none() || longest.flatten().is_none_or(|before| most > Some(before)) {
                self.slowest[index] = Some(Overrun { node: number, action });
            }
            *longest = Some(match (*longest, most) {
                (Some(None), _) | (_, None) => None,
                (Some(Some(before)), Some(most)) => Some(before.max(most)),
                (None, Some(most)) => Some(most),
            });
        }
    }

    /// Number of states, without values of clocks.
    #[must_use]
    pub fn states(&self) -> usize {
        self.table.all().len()
    }

    /// The states, in the order in which they were found.
    pub(crate) fn all(&self) -> impl Iterator<Item = State> + '_ {
        self.table.all()
    }

    /// Number of zones: those that no other one includes.
    #[must_use]
    pub fn zones(&self) -> usize {
        self.table.zones()
    }

    /// A run to an overrun: each state, and the step that leaves it.
    pub(crate) fn run_to(&self, system: &System, overrun: Overrun) -> Vec<(State, Action)> {
        self.table.run_to(system, (overrun.node, overrun.action))
    }
}

/// Whether a task is at work in a cycle that a tick began, while requests are served.
pub(super) fn works(state: &State, task: usize) -> bool {
    let task = &state.tasks[task];
    let works = !matches!(task.at, At::Absent | At::Sleep) && task.young == 0;
    works && state.phase == Phase::Running
}

impl System {
    /// Steps that are possible in a state if its clocks allow them: ticks come at work as well.
    pub(crate) fn timed(&self, state: &State) -> Vec<Action> {
        let mut actions = self.internal(state);
        actions.extend(self.hurries(state));
        actions.extend(self.returns(state));
        if state.phase != Phase::Stopped {
            let tasks = 0..crate::codels::small(self.periods.len());
            actions.extend(tasks.filter(|task| self.ticks_of(*task)).map(Action::Tick));
        }
        actions.extend(self.asked(state));
        actions
    }
}
