//! All states that a component can reach, whatever time its codels take.

use std::fmt;
use std::time::{Duration, Instant};

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use crate::action::Action;
use crate::memory::{ENTRY, listed};
use crate::pack::{pack, packed, unpacked};
use crate::state::State;
use crate::system::System;

/// Bytes that are taken for each state, beside the state itself.
const TABLES: usize = ENTRY + listed::<(u32, u16)>();

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
        Self { states: 5_000_000, memory: 1 << 30, time: Duration::from_secs(10) }
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

/// How much was explored.
#[derive(Clone, Copy, Debug)]
pub struct Looked {
    /// Number of states.
    pub states: usize,
    /// Number of steps between them.
    pub steps: usize,
    /// What ended the exploration early.
    pub limit: Option<Limit>,
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
        let first = packed(&system.initial(false));
        let mut all = Self {
            states: IndexSet::from_iter([first]),
            before: vec![(0, 0)],
            steps: 0,
            limit: None,
            took: Duration::ZERO,
        };
        let (mut at, mut bytes, mut told, mut packed) = (0, 0, Vec::new(), Vec::new());
        let mut next = system.initial(false);
        while let Some(state) = all.states.get_index(at).map(|bytes| unpacked(bytes)) {
            let number = u32::try_from(at).unwrap_or(u32::MAX);
            let enabled = system.enabled(&state);
            if !look(number, &state, &enabled) {
                break;
            }
            for (action, step) in enabled.iter().zip(0u16..) {
                system.after_into(&mut next, &state, *action, &mut told);
                pack(&next, &mut packed);
                told.clear();
                all.steps += 1;
                if !all.states.contains(packed.as_slice()) {
                    all.states.insert(packed.as_slice().into());
                    bytes += packed.len() + TABLES;
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

    /// How much that is.
    #[must_use]
    pub fn looked(&self) -> Looked {
        Looked { states: self.len(), steps: self.steps, limit: self.limit }
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
    /// Limits of a first look, in which what is small is seen as a whole: a part of the time, and a
    /// second and a half if that is allowed.
    #[must_use]
    pub fn first(&self) -> Self {
        const PART: u32 = 40;
        let time = (self.time / PART).max(Duration::from_millis(1500)).min(self.time);
        Self { states: self.states.min(500_000), time, ..*self }
    }

    /// The same with what is left of the time since `begin`, shared with so many others.
    pub(crate) fn share(&self, begin: Instant, others: usize) -> Self {
        let sharing = u32::try_from(others.saturating_add(1)).unwrap_or(u32::MAX);
        Self { time: self.time.saturating_sub(begin.elapsed()) / sharing, ..*self }
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
