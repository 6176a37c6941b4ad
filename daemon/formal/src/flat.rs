//! States and steps as a timed automaton: what languages without lists can say.
//!
//! `genom-export` writes it for other tools.

use std::collections::HashMap;

use crate::action::Action;
use crate::codels::small;
use crate::state::State;
use crate::system::System;
use crate::timed::{Clock, Timed, Times, begins, clocks, greatest, is_urgent};
use genom_timing::{Limit, Limits};

/// A timed automaton. Times are in units.
#[derive(Clone, Debug)]
pub struct Flat {
    /// Nanoseconds of a unit.
    pub unit: u64,
    /// Names of clocks.
    pub clocks: Vec<String>,
    /// Steps from all clocks at zero to the first state: the clock that is waited for, its value,
    /// and the clock that begins then.
    pub before: Vec<(String, u64, String)>,
    /// The states; the first one is where it begins.
    pub states: Vec<FlatState>,
    /// What leads from one to another.
    pub steps: Vec<FlatStep>,
    /// Tasks with a period: a tick at work leads to a location of their own, too.
    pub late: Vec<(u16, String)>,
}

/// A state.
#[derive(Clone, Debug)]
pub struct FlatState {
    /// No time passes here.
    pub urgent: bool,
    /// Clocks and their greatest values.
    pub most: Vec<(String, u64)>,
}

/// A step.
#[derive(Clone, Debug)]
pub struct FlatStep {
    /// The state before it.
    pub from: usize,
    /// What is after it.
    pub to: FlatTo,
    /// A clock and its least value.
    pub least: Option<(String, u64)>,
    /// Clocks that begin.
    pub begins: Vec<String>,
    /// What it is, for readers.
    pub what: String,
}

/// Where a step leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlatTo {
    /// To a state.
    State(usize),
    /// To one that cannot be reached, by what genomctl found.
    Unreachable,
    /// To the location that shows that a task is late.
    Late(u16),
}

impl System {
    /// The component while it takes such times, as a timed automaton.
    ///
    /// # Errors
    /// The limit that was reached before all states were found.
    pub fn flat(&self, times: &Times, limits: &Limits) -> Result<Flat, Limit> {
        flat(self, times, limits)
    }
}

fn flat(system: &System, times: &Times, limits: &Limits) -> Result<Flat, Limit> {
    let explored = Timed::new(system, times, limits);
    if let Some(limit) = explored.limit {
        return Err(limit);
    }
    let unit = times.unit(system);
    let states: Vec<State> = explored.all().collect();
    let places: HashMap<&State, usize> =
        states.iter().enumerate().map(|(at, state)| (state, at)).collect();
    let (mut locations, mut edges, mut told) = (Vec::new(), Vec::new(), Vec::new());
    for (from, state) in states.iter().enumerate() {
        let running = clocks(system, times, state);
        let most = running.iter().filter_map(|clock| {
            let most = greatest(system, times, state, *clock)?;
            Some((name(*clock), most / unit))
        });
        locations.push(FlatState { urgent: is_urgent(system, state), most: most.collect() });
        for action in system.timed(state) {
            let next = system.after(state, action, &mut told);
            told.clear();
            let new = clocks(system, times, &next).into_iter();
            let new = new.filter(|clock| begins(*clock, action) || !running.contains(clock));
            let edge = FlatStep {
                from,
                to: places.get(&next).map_or(FlatTo::Unreachable, |to| FlatTo::State(*to)),
                least: least(system, times, state, action).map(|(clock, ns)| (clock, ns / unit)),
                begins: new.map(name).collect(),
                what: system.words(state, action).map_or_else(
                    || format!("{action:?}"),
                    |line| format!("{}: {}", line.who, line.what),
                ),
            };
            if let Some(task) = Timed::is_late(state, action) {
                let (from, least) = (edge.from, edge.least.clone());
                let (to, what) =
                    (FlatTo::Late(task), format!("{} is late", system.task_name(task)));
                edges.push(FlatStep { from, to, least, begins: Vec::new(), what });
            }
            edges.push(edge);
        }
    }
    let ticks = system.periods.iter().zip(0u16..).filter(|(period, _)| period.is_some());
    let ticks: Vec<u16> = ticks.map(|(_, task)| task).collect();
    let contexts = 0..small(system.periods.len() + system.services.len());
    let all = ticks.iter().map(|task| Clock::Tick(*task)).chain(contexts.map(Clock::Since));
    Ok(Flat {
        unit,
        clocks: all.map(name).collect(),
        before: before(system, unit),
        states: locations,
        steps: edges,
        late: ticks.iter().map(|task| (*task, system.task_name(*task))).collect(),
    })
}

fn name(clock: Clock) -> String {
    match clock {
        Clock::Tick(task) => format!("t{task}"),
        Clock::Since(context) => format!("x{context}"),
        Clock::Followed(_) => "followed".into(),
        Clock::Noted(part, _) => format!("noted_{part}"),
    }
}

fn least(system: &System, times: &Times, state: &State, action: Action) -> Option<(String, u64)> {
    match action {
        Action::Tick(task) => {
            let period = system.periods[usize::from(task)]?;
            Some((name(Clock::Tick(task)), period.period))
        }
        Action::Return(context, _) => {
            let least = times.of(state.lock.held_by(context)?).least;
            (least > 0).then(|| (name(Clock::Since(context)), least))
        }
        _ => None,
    }
}

/// Clocks of ticks are where delays put them: the furthest one runs first, the others begin while
/// it does.
fn before(system: &System, unit: u64) -> Vec<(String, u64, String)> {
    let since = |(period, task): (&Option<crate::Period>, u16)| {
        let period = (*period)?;
        Some((period.before_start() / unit, name(Clock::Tick(task))))
    };
    let mut all: Vec<(u64, String)> = system.periods.iter().zip(0u16..).filter_map(since).collect();
    all.sort_by_key(|(since, _)| std::cmp::Reverse(*since));
    let Some((most, first)) = all.first().cloned() else { return Vec::new() };
    if most == 0 {
        return Vec::new();
    }
    let mut steps = Vec::new();
    for (since, clock) in all.into_iter().skip(1).filter(|(since, _)| *since < most) {
        steps.push((first.clone(), most - since, clock));
    }
    // The first state is entered when the furthest clock is where it has to be.
    steps.push((first, most, String::new()));
    steps
}
