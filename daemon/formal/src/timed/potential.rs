//! How long a cycle of a task may still get, by what each of its activities may execute.

use super::clocks::Clock;
use super::times::Times;
use crate::schedule::Dearest;
use crate::state::{At, Life, Mode, Run, State};
use crate::system::System;
use genom_timing::Zone;

use super::explore::works;

/// What each state of the machines of a task may lead to in one cycle.
pub(crate) struct Potential {
    task: u16,
    dearest: Dearest,
}

impl Potential {
    /// `None` if a cycle may have no end.
    pub(crate) fn new(system: &System, times: &Times, task: u16) -> Option<Self> {
        Some(Self { task, dearest: Dearest::new(system, times, task)? })
    }

    pub(super) fn task(&self) -> u16 {
        self.task
    }

    /// The longest time from its tick to the end of the cycle that a task is in, or of its next one
    /// with the activities that it has.
    pub(super) fn of(
        &self,
        system: &System,
        times: &Times,
        state: &State,
        (clocks, zone): (&[Clock], &Zone),
    ) -> u64 {
        let me = &state.tasks[usize::from(self.task)];
        if !works(state, usize::from(self.task)) {
            let sent = me.runs.iter().chain(&me.inbox);
            let waiting = state.pending.iter().filter_map(|pending| {
                let machine = system.services[usize::from(pending.service)].machine?;
                let own = system.machines[usize::from(machine)].task == self.task;
                own.then(|| self.dearest.begun(machine))
            });
            let runs = sent.map(|run| self.run(system, run, true, None));
            return runs.chain(waiting).fold(0, u64::saturating_add);
        }
        let present = match me.at {
            At::Codel { run, place } => Some((run, place)),
            _ => None,
        };
        let runs = me.runs.iter().zip(0u16..).map(|(run, at)| {
            let present = present.filter(|(of, _)| *of == at).map(|(_, place)| place);
            self.run(system, run, matches!(me.at, At::Begin { tick: true }), present)
        });
        let rest = runs.fold(0, u64::saturating_add);
        self.ends(times, state, (clocks, zone)).saturating_add(rest)
    }

    /// What a run may cost from where it is on, without the place that is executed.
    fn run(&self, system: &System, run: &Run, ticks: bool, present: Option<u16>) -> u64 {
        if run.end.is_some() || run.life == Life::Cancelled {
            return 0;
        }
        if run.life == Life::Init {
            return if ticks { self.dearest.begun(run.machine) } else { 0 };
        }
        let places = || {
            run.places.iter().zip(0u16..).filter_map(move |(place, at)| {
                let active = place.mode == Mode::Ready || ticks && place.mode == Mode::Paused;
                active.then_some((place.state, Some(at) == present))
            })
        };
        let sum = |later: bool| {
            let one = |(state, is_present): (u16, bool)| {
                self.dearest.from(run.machine, state, later, is_present)
            };
            places().map(one).fold(0, u64::saturating_add)
        };
        let ends = sum(false);
        let stop = self.dearest.stop(run.machine);
        let asks =
            run.life == Life::Run && system.machines[usize::from(run.machine)].service.is_some();
        match stop.filter(|_| asks) {
            Some(stop) => ends.max(sum(true).saturating_add(stop)),
            None => ends,
        }
    }

    /// When what the task executes ends at the latest, from its tick on.
    fn ends(&self, times: &Times, state: &State, (clocks, zone): (&[Clock], &Zone)) -> u64 {
        let place =
            |wanted: Clock| clocks.iter().position(|clock| *clock == wanted).map(|at| at + 1);
        let Some(tick) = place(Clock::Tick(self.task)) else { return 0 };
        let most = |node: u16| times.of(node).most.unwrap_or(0);
        let ends = |context: u16, node: u16| {
            let begun = place(Clock::Since(context)).and_then(|at| zone.difference(tick, at));
            u64::try_from(begun.unwrap_or(0)).unwrap_or(0).saturating_add(most(node))
        };
        if let Some(node) = state.lock.held_by(self.task) {
            return ends(self.task, node);
        }
        let now = zone.most(tick).and_then(|now| u64::try_from(now).ok()).unwrap_or(0);
        let Some(node) = state.lock.awaited_by(self.task) else { return now };
        // The last of those that are at work, then all that are ahead.
        let held = state.lock.holders().map(|(context, node)| ends(context, node)).max();
        let queue = state.lock.queue.iter().take_while(|(context, _)| *context != self.task);
        let queue = queue.map(|(_, node)| most(*node)).fold(0, u64::saturating_add);
        held.unwrap_or(now).saturating_add(queue).saturating_add(most(node))
    }
}
