//! Random walks to a tick that comes while its task is at work, each from where another one came to in a
//! cycle that may be late. They take the steps that [`seek`](super::seek) takes.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use genom_timing::memory::{PIECE, listed};
use genom_timing::{Limits, Random, Zone};

use super::clocks::{Clock, clocks, guarded, initial, stepped};
use super::explore::{Timed, works};
use super::potential::Potential;
use super::seek::{Steps, is_played, possible};
use super::times::Times;
use crate::action::{Action, Answer};
use crate::rules::runs_of;
use crate::state::{At, Pending, Run, State, Task, Worker};

/// Steps of a walk, at most.
const STEPS: usize = 200;
/// Places of the same level of which a walk begins at the one from where the longest cycle was found so far.
const PICKED: usize = 3;
/// Steps that are tried where a walk is before it is given up.
const TRIED: usize = 8;
/// Of walks, some have many requests, and some hardly any: percentages of steps that may be none.
const CALM: [usize; 4] = [50, 90, 96, 99];

/// A state with values of its clocks, and how long the cycle of the task may get.
#[derive(Clone)]
pub(super) struct Now {
    pub(super) state: State,
    clocks: Vec<Clock>,
    zone: Zone,
    pub(super) most: u64,
}

/// Where walks begin.
pub(super) struct Place {
    pub(super) now: Now,
    /// 0 if no cycle may be late; else 1, and one for each codel that the task has come to in it.
    pub(super) level: usize,
    /// The place before it, and the steps from there.
    before: usize,
    steps: Vec<Action>,
    /// The longest that the cycle may get, of all places where the task came to a codel from here.
    best: u64,
}

pub(super) struct Walks<'a> {
    times: &'a Times,
    pub(super) potential: &'a Potential<'a>,
    pub(super) random: &'a mut Random,
    pub(super) places: Vec<Place>,
    /// Places of each level.
    levels: Vec<Vec<usize>>,
    /// Memory that they take, about.
    bytes: usize,
}

/// A run in which this task is late, if one is found within the limits and before `over` is set; else
/// the number of places that walks began at.
pub(crate) fn walks(
    limits: &Limits,
    potential: &Potential<'_>,
    random: &mut Random,
    over: &AtomicBool,
) -> Result<Steps, usize> {
    let begin = Instant::now();
    let Potential { system, task, .. } = *potential;
    let times = &potential.times.longest_of(system, task);
    let state = system.initial(false);
    let (clocks, zone) =
        (clocks(system, times, &state), initial(system, times, &state).ok_or(1_usize)?);
    let (places, levels) = (Vec::new(), Vec::new());
    let mut walks = Walks { times, potential, random, places, levels, bytes: 0 };
    walks.keep(Now { state, clocks, zone, most: 0 }, 0, (0, Vec::new()));
    loop {
        let passed = limits.passed(walks.places.len(), walks.bytes, 0, begin).is_some();
        if passed || over.load(Ordering::Relaxed) {
            return Err(walks.places.len());
        }
        if walks.random.below(2) == 0 {
            walks.scene();
        } else if let Some(run) = walks.walk() {
            return Ok(run);
        }
    }
}

impl Walks<'_> {
    /// One walk; a run if it comes to a tick that is late.
    fn walk(&mut self) -> Option<Steps> {
        let Potential { task, period, .. } = *self.potential;
        let mut from = self.pick(usize::MAX)?;
        let mut now = self.places[from].now.clone();
        let mut steps = Vec::new();
        let calm = *self.random.one(&CALM);
        for _ in 0..STEPS {
            let level = self.places[from].level;
            let mut actions = self.possible(&now.state);
            let own = |action: &Action| match *action {
                Action::Return(of, _) | Action::Tick(of) | Action::Begin(of) => of == task,
                _ => false,
            };
            let (mut goes_on, mut others) = (None, Vec::new());
            for action in actions.extract_if(.., |action| level > 0 && own(action)) {
                if Timed::is_late(&now.state, action) == Some(task) {
                    if self.step(&now, action).is_some() {
                        let run = self.run(from, &steps, action);
                        if is_played(self.potential, &run) {
                            return Some(run);
                        }
                    }
                } else if let Some((next, taken)) = self.own(&now, action)
                    && self.may_be_late(&next, from)
                {
                    let steps = steps.iter().copied().chain(taken).collect();
                    let place = self.keep(next, level + 1, (from, steps));
                    goes_on = goes_on.or_else(|| (self.random.below(2) == 0).then_some(place));
                } else if level == 1 {
                    others.push(action);
                }
            }
            actions.extend(others);
            if let Some(place) = goes_on {
                (from, now, steps) = (place, self.places[place].now.clone(), Vec::new());
                continue;
            }
            let (requests, fails) = (self.random.below(100) >= calm, self.random.below(4) == 0);
            actions.retain(|action| match action {
                Action::Request(_) | Action::Abort(..) => requests,
                Action::Return(_, Answer::Fail) => fails,
                _ => true,
            });
            let tried = (0..actions.len().min(TRIED)).find_map(|_| {
                let action = actions.swap_remove(self.random.below(actions.len()));
                let next = self.step(&now, action)?;
                (level == 0 || next.most >= period || own(&action)).then_some((next, action))
            });
            let action;
            (now, action) = tried?;
            steps.push(action);
            if level < 2 && now.most > self.places[from].now.most || level == 1 && now.most < period
            {
                let level = usize::from(now.most >= period);
                from = self.keep(now.clone(), level, (from, std::mem::take(&mut steps)));
            }
        }
        None
    }

    /// A place to begin at, of one of the first levels.
    pub(super) fn pick(&mut self, levels: usize) -> Option<usize> {
        let levels = self.levels.iter().take(levels).filter(|level| !level.is_empty());
        let level = *self.random.one(&levels.collect::<Vec<_>>());
        let picked = (0..PICKED).map(|_| level[self.random.below(level.len())]);
        picked.max_by_key(|place| self.places[*place].best)
    }

    /// Whether the cycle may be late where the task comes to a codel after a place.
    pub(super) fn may_be_late(&mut self, now: &Now, mut after: usize) -> bool {
        while after > 0 && self.places[after].best < now.most {
            self.places[after].best = now.most;
            after = self.places[after].before;
        }
        now.most >= self.potential.period
    }

    /// Walks may begin here; returns the number of the place.
    pub(super) fn keep(
        &mut self,
        now: Now,
        level: usize,
        (before, steps): (usize, Vec<Action>),
    ) -> usize {
        let number = self.places.len();
        self.levels.resize(self.levels.len().max(level + 1), Vec::new());
        self.levels[level].push(number);
        let lists = steps.len() * listed::<Action>() + now.clocks.len() * listed::<Clock>();
        self.bytes += listed::<Place>() + lists + bytes(&now.state) + now.zone.bytes();
        self.places.push(Place { now, level, before, steps, best: 0 });
        number
    }

    pub(super) fn possible(&self, state: &State) -> Vec<Action> {
        possible(self.potential.system, state).into_iter().map(|(action, _)| action).collect()
    }

    pub(super) fn step(&self, now: &Now, action: Action) -> Option<Now> {
        let (system, times) = (self.potential.system, self.times);
        let possible = guarded(system, times, (&now.state, &now.clocks), &now.zone, action)?;
        let mut state = now.state.clone();
        system.after_into(&mut state, &now.state, action, &mut Vec::new());
        let clocks = clocks(system, times, &state);
        let from = (&now.clocks[..], &*possible);
        let zone = stepped(system, times, from, action, (&state, &clocks))?;
        let most = self.potential.of(&state, (&clocks, &zone));
        Some(Now { state, clocks, zone, most })
    }

    /// A step of the task, and those to its next codel; `None` if its cycle ends before.
    pub(super) fn own(&self, now: &Now, action: Action) -> Option<(Now, Vec<Action>)> {
        let task = self.potential.task;
        let (mut now, mut steps) = (self.step(now, action)?, vec![action]);
        loop {
            let action = match now.state.tasks[usize::from(task)].at {
                At::Begin { .. } => Action::Begin(task),
                At::Wake => Action::Wake(task),
                _ => break,
            };
            now = self.step(&now, action)?;
            steps.push(action);
        }
        works(&now.state, usize::from(task)).then_some((now, steps))
    }

    /// The run to a step after those that lead on from a place.
    fn run(&self, place: usize, steps: &[Action], last: Action) -> Steps {
        let (mut parts, mut at) = (vec![std::slice::from_ref(&last), steps], place);
        while at > 0 {
            parts.push(&self.places[at].steps);
            at = self.places[at].before;
        }
        let mut state = self.places[0].now.state.clone();
        let steps = parts.into_iter().rev().flatten();
        let after = |action: &Action| {
            let next = self.potential.system.after(&state, *action, &mut Vec::new());
            (std::mem::replace(&mut state, next), *action)
        };
        steps.map(after).collect()
    }
}

/// Memory that the lists of a state take.
fn bytes(state: &State) -> usize {
    let run = |run: &Run| PIECE + listed::<Run>() + run.places.len() * listed::<(u16, u16)>();
    let runs: usize = state.tasks.iter().flat_map(runs_of).map(run).sum();
    let tasks = state.tasks.len() * (listed::<Task>() + 4 * PIECE);
    let requests =
        state.pending.len() * listed::<Pending>() + state.workers.len() * listed::<Worker>();
    let lock = (state.lock.held.len() + state.lock.queue.len()) * listed::<(u16, u16)>();
    runs + tasks + requests + lock + 8 * PIECE
}
