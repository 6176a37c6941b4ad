//! Formulas that something comes: `<> q`, `[] <> q` and `[] (p -> <> q)`, of which `p` and `q` are
//! about one state each.
//!
//! One does not hold if a run goes on for ever without `q`, and that run is fair: no task, worker or
//! control that can go on from some state on is left waiting there for ever. Clients need not ask for
//! anything, and yields are not taken to be fair.

use std::time::Instant;

use indexmap::IndexSet;
use rustc_hash::FxBuildHasher;

use super::formula::{Comes, Formula, holds_in};
use crate::action::Action;
use crate::codels::small;
use crate::pack::{pack, unpacked};
use crate::property::{Finding, Verdict};
use crate::state::State;
use crate::system::System;
use crate::words::Line;
use genom_timing::memory::{ENTRY, PIECE, listed};
use genom_timing::{Limit, Limits, circles};

/// Bytes that are taken for each state, beside the state itself, and for each step.
const TABLES: usize =
    ENTRY + listed::<(u32, u16)>() + listed::<usize>() + 2 * listed::<bool>() + CIRCLES;
const STEP: usize = listed::<Edge>();
/// Of each state while circles are looked for: where it was reached from, its place in that order, the
/// numbers and lists of [`circles`], and a list of those in its circle.
const CIRCLES: usize = size_of::<Option<u32>>()
    + listed::<u32>()
    + 4 * size_of::<u32>()
    + listed::<u32>()
    + listed::<(u32, [usize; 4])>()
    + listed::<Vec<u32>>()
    + 4 * size_of::<u32>()
    + PIECE;
/// Steps that are told of those that repeat.
const TOLD: usize = 6;

/// A step: where it leads, and who takes it; nobody who must, if it is [`NOBODY`].
type Edge = (u32, u16);
const NOBODY: u16 = u16::MAX;

/// All states, and the steps between them.
struct Graph {
    states: IndexSet<Box<[u8]>, FxBuildHasher>,
    before: Vec<(u32, u16)>,
    /// Where the steps of each state begin in `edges`.
    first: Vec<usize>,
    edges: Vec<Edge>,
    /// States without `q`.
    without: Vec<bool>,
    /// States from which `q` must come.
    due: Vec<bool>,
    limit: Option<Limit>,
}

impl System {
    /// Whether something comes, as a formula says; `None` if it says something else.
    #[must_use]
    pub fn check_comes(&self, formula: &Formula, limits: &Limits) -> Option<Verdict> {
        let comes = formula.comes().filter(|_| !formula.has_late())?;
        let graph = Graph::new(self, &comes, limits);
        Some(match graph.limit {
            Some(limit) => {
                Verdict::Undecided(format!("{limit}: raise the limits, or lower the bounds"))
            }
            None => graph.verdict(self, formula),
        })
    }

    /// Who takes a step, by number, and must do so at some time: control, a task, a worker, or what
    /// collects the ended activities of a task.
    fn taker(&self, action: Action) -> u16 {
        let (tasks, services) = (small(self.periods.len()), small(self.services.len()));
        match action {
            Action::Start | Action::Advance | Action::Collect(None) => 0,
            Action::Tick(task) | Action::Hurry(task) | Action::Begin(task) | Action::Wake(task) => {
                1 + task
            }
            Action::Return(context, _) => 1 + context,
            Action::Proceed(service) => 1 + tasks + service,
            Action::Collect(Some(task)) => 1 + tasks + services + task,
            Action::Request(_) | Action::Abort(..) | Action::Fire(..) | Action::Kill => NOBODY,
        }
    }
}

impl Graph {
    fn new(system: &System, comes: &Comes<'_>, limits: &Limits) -> Self {
        let begin = Instant::now();
        let (mut packed, mut told) = (Vec::new(), Vec::new());
        let mut next = system.initial(false);
        pack(&next, &mut packed);
        let mut all = Self {
            states: IndexSet::from_iter([packed.as_slice().into()]),
            before: vec![(0, 0)],
            first: vec![0],
            edges: Vec::new(),
            without: Vec::new(),
            due: Vec::new(),
            limit: None,
        };
        let (mut bytes, mut at) = (0, 0);
        while let Some(state) = all.states.get_index(at).map(|bytes| unpacked(bytes)) {
            let without = !holds_in(comes.goal, system, &state);
            let due = comes.whenever.map_or(at == 0, |when| holds_in(when, system, &state));
            all.without.push(without);
            all.due.push(due && without);
            for (action, step) in system.enabled(&state).into_iter().zip(0u16..) {
                system.after_into(&mut next, &state, action, &mut told);
                pack(&next, &mut packed);
                told.clear();
                let to = match all.states.get_index_of(packed.as_slice()) {
                    Some(to) => to,
                    None => {
                        bytes += packed.len() + TABLES;
                        all.before.push((index(at), step));
                        all.states.insert_full(packed.as_slice().into()).0
                    }
                };
                bytes += STEP;
                all.edges.push((index(to), system.taker(action)));
            }
            all.first.push(all.edges.len());
            at += 1;
            all.limit = limits.passed(all.states.len(), bytes, at, begin);
            if all.limit.is_some() {
                break;
            }
        }
        all
    }

    fn edges(&self, state: u32) -> &[Edge] {
        let at = state as usize;
        &self.edges[self.first[at]..self.first[at + 1]]
    }

    fn verdict(&self, system: &System, formula: &Formula) -> Verdict {
        // States that are reached without `q` from one from which it must come, and from which.
        let mut from: Vec<Option<u32>> = vec![None; self.without.len()];
        let due = (0..index(self.due.len())).filter(|at| self.due[*at as usize]);
        let mut order: Vec<u32> = due.collect();
        order.iter().for_each(|at| from[*at as usize] = Some(*at));
        let mut at = 0;
        while let Some(state) = order.get(at).copied() {
            at += 1;
            for (to, _) in self.edges(state) {
                if self.without[*to as usize] && from[*to as usize].is_none() {
                    from[*to as usize] = Some(state);
                    order.push(*to);
                }
            }
        }
        let next = |state: u32| {
            let edges = self.edges(state).iter().map(|(to, _)| *to);
            edges.filter(|to| self.without[*to as usize])
        };
        let circle = circles(self.without.len(), &order, next);
        let mut members: Vec<Vec<u32>> = Vec::new();
        for state in &order {
            let of = circle[*state as usize] as usize;
            if members.len() <= of {
                members.resize(of + 1, Vec::new());
            }
            members[of].push(*state);
        }
        // In the order in which they were found: the first one is among the nearest.
        let fair = |state: &&u32| {
            self.is_fair(system, &circle, &members[circle[**state as usize] as usize])
        };
        let mut known = vec![false; members.len()];
        let new =
            |state: &&u32| !std::mem::replace(&mut known[circle[**state as usize] as usize], true);
        match order.iter().filter(new).find(fair) {
            None => Verdict::Holds,
            Some(state) => {
                let mut run = self.run(system, &from, *state);
                run.extend(self.repeated(
                    system,
                    &circle,
                    &members[circle[*state as usize] as usize],
                ));
                let what = format!("a run goes on for ever in which `{formula}` does not hold");
                Verdict::Violated(vec![Finding { what, span: None, run }])
            }
        }
    }

    /// Whether a fair run can stay in these states, which can all be reached from each other.
    fn is_fair(&self, system: &System, circle: &[u32], members: &[u32]) -> bool {
        let count = 1 + 2 * system.periods.len() + system.services.len();
        // Who could go on in all of these states, and does not.
        let mut left = vec![true; count];
        for state in members {
            let mut can = vec![false; count];
            for (to, taker) in self.edges(*state).iter().filter(|(_, taker)| *taker != NOBODY) {
                can[usize::from(*taker)] = true;
                if self.is_inside(circle, *state, *to) {
                    left[usize::from(*taker)] = false;
                }
            }
            left.iter_mut().zip(&can).for_each(|(left, can)| *left &= can);
        }
        !left.contains(&true)
    }

    fn is_inside(&self, circle: &[u32], state: u32, to: u32) -> bool {
        self.without[to as usize] && circle[state as usize] == circle[to as usize]
    }

    /// A run to a state, without `q` from where it must come.
    fn run(&self, system: &System, from: &[Option<u32>], state: u32) -> Vec<Line> {
        let (mut lines, mut at) = (Vec::new(), state);
        while let Some(before) = from[at as usize].filter(|before| *before != at) {
            let step = self.edges(before).iter().position(|(to, _)| *to == at);
            lines.extend(self.line(system, before, step));
            at = before;
        }
        while at > 0 {
            let (before, step) = self.before[at as usize];
            lines.extend(self.line(system, before, Some(usize::from(step))));
            at = before;
        }
        lines.reverse();
        lines
    }

    fn line(&self, system: &System, state: u32, step: Option<usize>) -> Option<Line> {
        let state = self.state(state)?;
        let action = *system.enabled(&state).get(step?)?;
        system.words(&state, action)
    }

    fn state(&self, number: u32) -> Option<State> {
        self.states.get_index(number as usize).map(|bytes| unpacked(bytes))
    }

    /// What happens again and again.
    fn repeated(&self, system: &System, circle: &[u32], members: &[u32]) -> Option<Line> {
        let mut all: Vec<String> = Vec::new();
        for state in members {
            for (step, (to, _)) in self.edges(*state).iter().enumerate() {
                let inside = self.is_inside(circle, *state, *to);
                let line = || self.line(system, *state, Some(step));
                if let Some(line) = inside.then(line).flatten() {
                    let words = format!("{}: {}", line.who, line.what);
                    if !all.contains(&words) {
                        all.push(words);
                    }
                }
            }
            if all.len() > TOLD {
                all.truncate(TOLD);
                all.push("…".into());
                break;
            }
        }
        let what = match all.is_empty() {
            true => "nothing more happens".into(),
            false => format!("no more than this happens: {}", all.join("; ")),
        };
        Some(Line { who: "from then on".into(), what, span: None })
    }
}

fn index(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}
