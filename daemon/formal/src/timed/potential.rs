//! How long a cycle of a task may still get, by what each of its activities may execute.

use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

use super::clocks::Clock;
use super::explore::works;
use super::still::{Nodes, has, still};
use super::times::Times;
use crate::action::Answer;
use crate::schedule::{CycleLength, Dearest, Does};
use crate::state::{At, Life, Mode, Pc, Place, Run, State};
use crate::system::System;
use genom_timing::Zone;

/// Lists of nodes of others that are told apart.
const LISTS: usize = 5_000;

/// What each state of the machines of a task may lead to in one cycle.
pub(crate) struct Potential<'a> {
    pub(super) system: &'a System,
    pub(super) times: &'a Times,
    pub(super) task: u16,
    pub(super) period: u64,
    dearest: Rc<Dearest>,
    /// The same, if other tasks may only execute some nodes any more.
    known: RefCell<HashMap<Nodes, Rc<Dearest>>>,
    longest: &'a CycleLength<'a>,
}

impl<'a> Potential<'a> {
    /// `None` if a cycle may have no end.
    pub(crate) fn new(
        system: &'a System,
        times: &'a Times,
        task: u16,
        longest: &'a CycleLength<'a>,
    ) -> Option<Self> {
        let dearest = Rc::new(Dearest::new(system, times, task, &|_, _| true)?);
        let period = system.periods[usize::from(task)]?.period;
        let known = RefCell::default();
        Some(Self { system, times, task, period, dearest, known, longest })
    }

    /// The longest time from its tick to the end of the cycle that a task is in, or of its next one
    /// with the activities that it has.
    pub(super) fn of(&self, state: &State, (clocks, zone): (&[Clock], &Zone)) -> u64 {
        let me = &state.tasks[usize::from(self.task)];
        let begins = matches!(me.at, At::Begin { tick: true });
        if begins || !works(state, usize::from(self.task)) {
            let waiting = self.waiting(state);
            // Once the tick has come, those that wait may be sent too late for that.
            let stays = |run: &&Run| begins || !self.is_stopped(run, &waiting);
            let sent = || me.runs.iter().chain(&me.inbox).filter(stays);
            let runs = sent().map(|run| self.run(&self.dearest, run, (true, true), None));
            let more = waiting.iter().map(|machine| self.dearest.begun(*machine));
            let sum = runs.chain(more).fold(0, u64::saturating_add);
            let listed =
                if sum < self.period { None } else { listed(self.system, sent(), &waiting) };
            return listed.map_or(sum, |runs| sum.min((self.longest)(&runs)));
        }
        let present = match me.at {
            At::Codel { run, place } => Some((run, place)),
            _ => None,
        };
        // Who is asked to stop does so in another pass.
        let goes = |run: &Run| {
            let ready = run.places.iter().filter(|place| place.mode == Mode::Ready);
            let codels = ready.filter_map(|place| {
                self.system.machines[usize::from(run.machine)].codel(place.state)
            });
            let answers = codels.flat_map(|codel| &self.system.codels[usize::from(codel)].answers);
            run.end.is_none() && answers.into_iter().any(|answer| matches!(answer, Answer::Go(_)))
        };
        let again = me.again || matches!(me.at, At::Begin { .. }) || me.runs.iter().any(goes);
        let sum = |dearest: &Dearest| {
            let runs = me.runs.iter().zip(0u16..).map(|(run, at)| {
                let present = present.filter(|(of, _)| *of == at).map(|(_, place)| place);
                self.run(dearest, run, (false, again), present)
            });
            let rest = runs.fold(0, u64::saturating_add);
            self.ends(state, (clocks, zone)).saturating_add(rest)
        };
        let all = sum(&self.dearest);
        if all < self.period {
            return all;
        }
        sum(&self.dearest_with(still((self.system, self.times), self.task, state, (clocks, zone))))
    }

    /// What there is to come if other tasks execute nothing else any more.
    fn dearest_with(&self, nodes: Nodes) -> Rc<Dearest> {
        let mut known = self.known.borrow_mut();
        if known.len() >= LISTS && !known.contains_key(&nodes) {
            return self.dearest.clone();
        }
        let known = known.entry(nodes).or_insert_with_key(|nodes| {
            let may = |context: u16, node: u16| !self.system.is_task(context) || has(nodes, node);
            let found = Dearest::new(self.system, self.times, self.task, &may);
            found.map_or_else(|| self.dearest.clone(), Rc::new)
        });
        known.clone()
    }

    /// When what the task executes ends, from the tick before on; or how old its last tick may be.
    pub(super) fn progress(&self, state: &State, (clocks, zone): (&[Clock], &Zone)) -> u64 {
        let before = if works(state, usize::from(self.task)) { self.period } else { 0 };
        before.saturating_add(self.ends(state, (clocks, zone)))
    }

    /// Machines of activities that were requested and not sent to the task.
    fn waiting(&self, state: &State) -> Vec<u16> {
        let served = state.workers.iter().filter(|worker| worker.pc != Pc::Wake(false));
        let pending = state.pending.iter().map(|pending| pending.service);
        let all = pending
            .chain(served.map(|worker| worker.service))
            .filter_map(|service| self.system.services[usize::from(service)].machine);
        all.filter(|one| self.system.machines[usize::from(*one)].task == self.task).collect()
    }

    /// Whether a run is stopped before these activities are sent.
    fn is_stopped(&self, run: &Run, waiting: &[u16]) -> bool {
        let service = |machine: u16| self.system.machines[usize::from(machine)].service;
        let mut others = waiting.iter().filter_map(|machine| service(*machine));
        service(run.machine)
            .is_some_and(|own| others.any(|other| self.system.interrupts(other, own)))
    }

    /// What a run may cost from where it is on, without the place that is executed.
    fn run(
        &self,
        dearest: &Dearest,
        run: &Run,
        (ticks, again): (bool, bool),
        present: Option<u16>,
    ) -> u64 {
        if run.end.is_some() || run.life == Life::Cancelled {
            return 0;
        }
        if run.life == Life::Init {
            return if ticks { dearest.begun(run.machine) } else { 0 };
        }
        let from = |(place, at): (&Place, u16), later: bool| {
            dearest.from(run.machine, place.state, later, Some(at) == present)
        };
        let places = || run.places.iter().zip(0u16..);
        let active = |mode: Mode| mode == Mode::Ready || ticks && mode == Mode::Paused;
        let sum = |later: bool| {
            let all = places().filter(|(place, _)| active(place.mode));
            all.filter_map(|one| from(one, later)).fold(0, u64::saturating_add)
        };
        // What is executed and can only end does so whether it is asked to stop or not.
        let asked = |one: (&Place, u16)| Some(one.1) != present || from(one, true).is_some();
        let is_asked = again
            && run.life == Life::Run
            && self.system.machines[usize::from(run.machine)].service.is_some()
            && places().any(|one| one.0.mode != Mode::Done && asked(one));
        let stop = dearest.stop(run.machine).filter(|_| is_asked);
        sum(false).max(stop.map_or(0, |stop| sum(true).saturating_add(stop)))
    }

    /// When what the task executes ends at the latest, from its tick on.
    fn ends(&self, state: &State, (clocks, zone): (&[Clock], &Zone)) -> u64 {
        let place =
            |wanted: Clock| clocks.iter().position(|clock| *clock == wanted).map(|at| at + 1);
        let Some(tick) = place(Clock::Tick(self.task)) else { return 0 };
        let most = |node: u16| self.times.of(node).most.unwrap_or(0);
        let ends = |context: u16, node: u16| {
            let begun = place(Clock::Since(context)).and_then(|at| zone.difference(tick, at));
            u64::try_from(begun.unwrap_or(0)).unwrap_or(0).saturating_add(most(node))
        };
        let now = zone.most(tick).and_then(|now| u64::try_from(now).ok()).unwrap_or(0);
        let all = state.lock.ends(&self.system.conflicts, (self.task, now), ends, most);
        all.unwrap_or(now)
    }
}

/// What runs do at the next tick of their task, and activities that begin then; `None` in the start-up.
fn listed<'r>(
    system: &System,
    runs: impl Iterator<Item = &'r Run>,
    waiting: &[u16],
) -> Option<Vec<(u16, Does)>> {
    let mut all = Vec::new();
    for run in runs {
        let machine = &system.machines[usize::from(run.machine)];
        let stopped = run.life == Life::Stop;
        let does = match (run.life, run.places.first().map(|place| (place.mode, place.state))) {
            (Life::Init, _) if machine.service.is_some() => Does::Begins,
            (Life::Init, _) | (_, Some((Mode::Ready | Mode::Done, _))) => return None,
            (Life::Run, _) if run.asked => Does::Ready { state: machine.stop, stopped: true },
            (Life::Run | Life::Stop, Some((Mode::Paused, state))) => Does::Ready { state, stopped },
            (Life::Run, Some((Mode::Asleep, _))) => Does::Rests,
            _ => continue,
        };
        all.push((run.machine, does));
    }
    all.extend(waiting.iter().map(|machine| (*machine, Does::Begins)));
    Some(all)
}
