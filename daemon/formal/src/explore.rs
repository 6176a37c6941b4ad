//! All states that a component can reach, whatever time its codels take.

use std::time::{Duration, Instant};

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use crate::action::Action;
use crate::pack::{pack, packed, unpacked};
use crate::state::State;
use crate::system::System;
use genom_timing::memory::{ENTRY, listed};
use genom_timing::{Limit, Limits};

/// Bytes that are taken for each state, beside the state itself.
const TABLES: usize = ENTRY + listed::<(u32, u16)>();

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
