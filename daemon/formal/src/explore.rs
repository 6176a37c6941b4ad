//! All states that a component can reach, whatever time its codels take.

use std::fmt;
use std::time::{Duration, Instant};

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use crate::action::Action;
use crate::pack::{pack, packed, unpacked};
use crate::state::State;
use crate::system::System;

/// Bytes that the tables take for each state, beside the state itself.
const TABLES: usize = 48;

/// Limits of an exploration.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Number of states.
    pub states: usize,
    /// Memory, in bytes.
    pub memory: usize,
    /// Time.
    pub time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self { states: 5_000_000, memory: 1 << 30, time: Duration::from_secs(60) }
    }
}

/// The limit that ended an exploration before all states were seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// [`Limits::states`].
    States(usize),
    /// [`Limits::memory`].
    Memory(usize),
    /// [`Limits::time`].
    Time(Duration),
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::States(states) => write!(f, "more than {states} states"),
            Self::Memory(bytes) => write!(f, "more than {} MiB of states", bytes >> 20),
            Self::Time(time) => write!(f, "more than {} s", time.as_secs_f64()),
        }
    }
}

/// States that were reached, in order of their distance from the first one.
#[derive(Debug)]
pub struct Explored {
    states: IndexSet<Box<[u8]>, FxBuildHasher>,
    /// For each state, the one before it and the number of the step between them.
    before: Vec<(u32, u16)>,
    /// Number of steps between them.
    pub steps: usize,
    /// What ended the exploration early.
    pub limit: Option<Limit>,
    /// Time that it took.
    pub took: Duration,
}

impl Explored {
    /// Explores the system from its first state on. `look` is shown each state once, with its number
    /// and the steps that it enables.
    pub fn new(
        system: &System,
        limits: &Limits,
        mut look: impl FnMut(u32, &State, &[Action]),
    ) -> Self {
        let look = |number, state: &State, enabled: &[Action]| {
            look(number, state, enabled);
            true
        };
        Self::whilst(system, limits, look)
    }

    /// The same, for as long as `look` returns `true`.
    pub(crate) fn whilst(
        system: &System,
        limits: &Limits,
        mut look: impl FnMut(u32, &State, &[Action]) -> bool,
    ) -> Self {
        let begin = Instant::now();
        let mut all = Self {
            states: IndexSet::from_iter([packed(&system.initial(false))]),
            before: vec![(0, 0)],
            steps: 0,
            limit: None,
            took: Duration::ZERO,
        };
        let (mut at, mut bytes, mut told, mut next) = (0, 0, Vec::new(), Vec::new());
        while let Some(state) = all.states.get_index(at).map(|bytes| unpacked(bytes)) {
            let number = u32::try_from(at).unwrap_or(u32::MAX);
            let enabled = system.enabled(&state);
            if !look(number, &state, &enabled) {
                break;
            }
            for (action, step) in enabled.iter().zip(0u16..) {
                pack(&system.after(&state, *action, &mut told), &mut next);
                told.clear();
                all.steps += 1;
                if !all.states.contains(next.as_slice()) {
                    all.states.insert(next.as_slice().into());
                    bytes += next.len() + TABLES;
                    all.before.push((number, step));
                }
            }
            at += 1;
            all.limit = limits.passed(all.states.len(), bytes, at, begin);
            if all.limit.is_some() {
                break;
            }
        }
        all.took = begin.elapsed();
        all
    }

    /// Number of states.
    #[must_use]
    pub fn len(&self) -> usize {
        self.states.len()
    }

    /// Whether there is no state. There always is one.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.states.is_empty()
    }

    /// A shortest run from the first state to the one with this number: each state, and the step
    /// that leaves it.
    #[must_use]
    pub fn run_to(&self, system: &System, number: u32) -> Vec<(State, Action)> {
        let mut steps = Vec::new();
        let mut at = number;
        while at > 0 {
            let Some(&(before, step)) = self.before.get(at as usize) else { break };
            steps.push((before, step));
            at = before;
        }
        let taken = steps.into_iter().rev().filter_map(|(before, step)| {
            let state = unpacked(self.states.get_index(before as usize)?);
            let action = *system.enabled(&state).get(usize::from(step))?;
            Some((state, action))
        });
        taken.collect()
    }
}

impl Limits {
    /// Limits of a first look, in which what is small is seen as a whole.
    #[must_use]
    pub fn first(&self) -> Self {
        let time = self.time.min(Duration::from_secs(2));
        Self { states: self.states.min(100_000), time, ..*self }
    }

    pub(crate) fn passed(
        &self,
        states: usize,
        bytes: usize,
        at: usize,
        begin: Instant,
    ) -> Option<Limit> {
        /// States between two looks at the clock.
        const LOOK: usize = 256;
        if states > self.states {
            return Some(Limit::States(self.states));
        }
        if bytes > self.memory {
            return Some(Limit::Memory(self.memory));
        }
        let late = at.is_multiple_of(LOOK) && begin.elapsed() > self.time;
        late.then_some(Limit::Time(self.time))
    }
}
