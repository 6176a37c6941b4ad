//! Formulas that must hold in every state, and speak of what was before (Havelund, Rosu:
//! Synthesizing Monitors for Safety Properties, 2002): each state is looked at with what each part of
//! the formula was in the state before.

use std::time::Instant;

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use super::formula::{Formula, Term};
use crate::pack::{pack, unpacked};
use crate::property::{Finding, Verdict};
use crate::state::State;
use crate::system::System;
use crate::words::Line;
use genom_timing::Limits;
use genom_timing::memory::{ENTRY, listed};

/// Parts of a formula: their truths are bits.
const PARTS: usize = 64;
/// Bytes that tables take for each state, beside the state itself.
const TABLES: usize = ENTRY + listed::<(usize, u16)>();

/// A formula as a list: parts come before what they are part of.
struct List<'f> {
    terms: Vec<(&'f Term, Vec<usize>)>,
    /// Those whose truth in the state before counts.
    kept: u64,
}

impl<'f> List<'f> {
    fn new(body: &'f Term) -> Option<Self> {
        let mut list = Self { terms: Vec::new(), kept: 0 };
        list.add(body);
        for (at, (term, parts)) in list.terms.iter().enumerate() {
            list.kept |= match term {
                Term::Once(_) | Term::Historically(_) | Term::Since(..) => 1 << (at % PARTS),
                Term::Previous(_) => 1 << (parts[0] % PARTS),
                _ => 0,
            };
        }
        (list.terms.len() <= PARTS).then_some(list)
    }

    fn add(&mut self, term: &'f Term) -> usize {
        let parts = term.parts().into_iter().map(|part| self.add(part)).collect();
        self.terms.push((term, parts));
        self.terms.len() - 1
    }

    /// The truths of all parts in a state, by those in the state before.
    fn now(&self, system: &System, state: &State, before: Option<u64>) -> u64 {
        let mut now = 0u64;
        for (at, (term, parts)) in self.terms.iter().enumerate() {
            let part = |number: usize| now >> parts[number] & 1 == 1;
            let was = |at: usize| before.map(|before| before >> at & 1 == 1);
            let holds = match term {
                Term::Const(value) => *value,
                Term::Atom(atom) => atom.holds(system, state),
                Term::Not(_) => !part(0),
                Term::Two(join, ..) => join.of(part(0), part(1)),
                Term::Once(_) => part(0) || was(at) == Some(true),
                Term::Historically(_) => part(0) && was(at) != Some(false),
                Term::Since(..) => part(1) || part(0) && was(at) == Some(true),
                Term::Previous(_) => was(parts[0]) == Some(true),
                // No part of what is looked at here.
                Term::Always(_) | Term::Eventually(_) | Term::Until(..) => false,
            };
            now |= u64::from(holds) << at;
        }
        now
    }

    fn holds(&self, now: u64) -> bool {
        now >> (self.terms.len() - 1) & 1 == 1
    }
}

impl System {
    /// Whether a formula about the past holds in all states; `None` if it is none, or speaks of ticks
    /// that come too soon, which takes times.
    #[must_use]
    pub fn check_past(&self, formula: &Formula, limits: &Limits) -> Option<Verdict> {
        let body = formula.always().filter(|_| !formula.has_late())?;
        let list = List::new(body)?;
        let begin = Instant::now();
        let mut packed = Vec::new();
        let mut states: IndexSet<Box<[u8]>, FxBuildHasher> = IndexSet::default();
        let mut before: Vec<(usize, u16)> = vec![(0, 0)];
        let (mut bytes, mut at, mut told) = (0, 0, Vec::new());
        let first = self.initial(false);
        let now = list.now(self, &first, None);
        states.insert(key(&first, now & list.kept, &mut packed));
        if !list.holds(now) {
            return Some(violated(formula, Vec::new()));
        }
        let mut next = first;
        while let Some((state, was)) = states.get_index(at).map(|bytes| split(bytes)) {
            for (action, step) in self.enabled(&state).into_iter().zip(0u16..) {
                self.after_into(&mut next, &state, action, &mut told);
                told.clear();
                let now = list.now(self, &next, Some(was));
                if !list.holds(now) {
                    let mut run = lines(self, &states, &before, at);
                    run.extend(self.words(&state, action));
                    return Some(violated(formula, run));
                }
                let key = key(&next, now & list.kept, &mut packed);
                let length = key.len();
                if states.insert(key) {
                    bytes += length + TABLES;
                    before.push((at, step));
                }
            }
            at += 1;
            if let Some(limit) = limits.passed(states.len(), bytes, at, begin) {
                let why = format!("{limit}: raise the limits, or lower the bounds");
                return Some(Verdict::Undecided(why));
            }
        }
        Some(Verdict::Holds)
    }
}

fn violated(formula: &Formula, run: Vec<Line>) -> Verdict {
    let what = format!("after this, `{formula}` does not hold");
    Verdict::Violated(vec![Finding { what, span: None, run }])
}

fn key(state: &State, kept: u64, packed: &mut Vec<u8>) -> Box<[u8]> {
    pack(state, packed);
    packed.extend(kept.to_le_bytes());
    packed.as_slice().into()
}

fn split(bytes: &[u8]) -> (State, u64) {
    let (state, kept) = bytes.split_at(bytes.len().saturating_sub(8));
    let kept = kept.try_into().map_or(0, u64::from_le_bytes);
    (unpacked(state), kept)
}

/// A run to a state, in words.
fn lines(
    system: &System,
    states: &IndexSet<Box<[u8]>, FxBuildHasher>,
    before: &[(usize, u16)],
    mut at: usize,
) -> Vec<Line> {
    let mut lines = Vec::new();
    while at > 0 {
        let (from, step) = before[at];
        let Some((state, _)) = states.get_index(from).map(|bytes| split(bytes)) else { break };
        let action = system.enabled(&state).get(usize::from(step)).copied();
        lines.extend(action.and_then(|action| system.words(&state, action)));
        at = from;
    }
    lines.reverse();
    lines
}
