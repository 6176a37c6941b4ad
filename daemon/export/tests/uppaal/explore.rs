//! All states of a model, as UPPAAL's semantics says, with time in whole units. Bounds of clocks are
//! closed, so that what can be reached at any date can be reached at a whole one.

use super::code::Expr;
use super::file::{Edge, Model};
use super::graph::{Graph, reached};
use super::memory::{Machine, Values};

/// Where each process is, and the values of all variables.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct State {
    at: Vec<u8>,
    values: Values,
}

/// What was found.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) graph: Graph,
    /// Of each query, its comment and whether it holds.
    pub(crate) verdicts: Vec<(String, bool)>,
}

impl Found {
    /// Whether the query with this comment holds.
    pub(crate) fn holds(&self, comment: &str) -> bool {
        let found = self.verdicts.iter().find(|(of, _)| of.starts_with(comment));
        found.unwrap_or_else(|| panic!("nothing says {comment}")).1
    }
}

/// The states of a model.
pub(crate) struct Explorer<'m> {
    model: &'m Model,
    /// Of each clock, when its value is of interest.
    counts: Vec<Option<Expr>>,
    /// What is seen of a state.
    seen: Vec<Expr>,
    /// A value of clocks above all that they are compared with.
    most: i32,
}

impl<'m> Explorer<'m> {
    pub(crate) fn new(model: &'m Model) -> Self {
        let most = model.fixed.constants.iter().max().map_or(1, |most| most + 1);
        Self { model, counts: vec![None; model.clocks().len()], seen: Vec::new(), most }
    }

    /// A clock is of interest only where this holds. Where it does not, it is as if it was too late for
    /// everything: so where it is of interest again and was not set, nothing is possible any more.
    pub(crate) fn counting(mut self, clock: usize, only: Expr) -> Self {
        self.counts[clock] = Some(only);
        self
    }

    /// Of states, the values of these are seen.
    pub(crate) fn seeing(self, seen: Vec<Expr>) -> Self {
        Self { seen, ..self }
    }

    fn holds(&self, values: &mut Values, expr: Option<&Expr>) -> bool {
        expr.is_none_or(|expr| Machine::new(&self.model.fixed, values).holds(expr))
    }

    /// All processes are where they may be.
    fn may_be(&self, state: &mut State) -> bool {
        let at = self.model.processes.iter().zip(&state.at);
        let mut invariants = at.map(|(of, at)| of.places[usize::from(*at)].invariant.as_ref());
        invariants.all(|invariant| self.holds(&mut state.values, invariant))
    }

    /// Of clocks, only what is of interest.
    fn settle(&self, state: &mut State) {
        for (clock, only) in self.counts.iter().enumerate() {
            let value = state.values.clocks[clock].min(self.most);
            let counts = self.holds(&mut state.values, only.as_ref());
            state.values.clocks[clock] = if counts { value } else { self.most };
        }
    }

    /// What an edge leads to, for each selection with which it is possible.
    fn taken(&self, state: &State, process: usize, edge: &Edge, next: &mut Vec<State>) {
        let mut selected: Vec<i32> = edge.selects.iter().map(|(least, _)| *least).collect();
        loop {
            let mut values = state.values.clone();
            let mut machine = Machine::new(&self.model.fixed, &mut values);
            machine.stack.clone_from(&selected);
            if edge.guard.as_ref().is_none_or(|guard| machine.holds(guard)) {
                for assign in &edge.assign {
                    machine.value(assign);
                }
                let mut at = state.at.clone();
                at[process] = u8::try_from(edge.to).expect("few locations");
                let mut after = State { at, values };
                if self.may_be(&mut after) {
                    self.settle(&mut after);
                    next.push(after);
                }
            }
            let ends = |(value, (_, most)): (&i32, &(i32, i32))| value < most;
            let Some(grows) = selected.iter().zip(&edge.selects).position(ends) else { return };
            selected[grows] += 1;
            for (value, (least, _)) in selected.iter_mut().zip(&edge.selects).take(grows) {
                *value = *least;
            }
        }
    }

    /// What steps lead to, and whether time may pass before them.
    fn steps(&self, state: &State, next: &mut Vec<State>) -> bool {
        let places = || {
            let at = self.model.processes.iter().zip(&state.at);
            at.map(|(of, at)| (of, usize::from(*at)))
        };
        let committed = places().any(|(of, at)| of.places[at].committed);
        let mut urgent = committed || places().any(|(of, at)| of.places[at].urgent);
        for (process, (of, at)) in places().enumerate() {
            for edge in of.edges.iter().filter(|edge| edge.from == at) {
                let before = next.len();
                self.taken(state, process, edge, next);
                urgent |= edge.urgent && next.len() > before;
                if committed && !of.places[at].committed {
                    next.truncate(before);
                }
            }
        }
        !urgent
    }

    /// The state after a unit of time, if it may pass.
    fn later(&self, state: &State) -> Option<State> {
        let mut later = state.clone();
        later.values.clocks.iter_mut().for_each(|clock| *clock += 1);
        let may = !later.values.clocks.is_empty() && self.may_be(&mut later);
        self.settle(&mut later);
        may.then_some(later)
    }

    /// Whether no step is possible, however long one waits.
    fn is_deadlock(&self, state: &State) -> bool {
        let (mut now, mut next) = (state.clone(), Vec::new());
        loop {
            let may_wait = self.steps(&now, &mut next);
            let later = self.later(&now).filter(|_| may_wait && next.is_empty());
            match later {
                Some(later) if later != now => now = later,
                _ => return next.is_empty(),
            }
        }
    }

    /// All states, if there are not more than that.
    pub(crate) fn explore(&self, limit: usize) -> Option<Found> {
        let at =
            self.model.processes.iter().map(|of| u8::try_from(of.init).expect("few locations"));
        let mut first = State { at: at.collect(), values: self.model.first.clone() };
        assert!(self.may_be(&mut first), "the first state breaks an invariant");
        self.settle(&mut first);
        let queries = &self.model.queries;
        let mut verdicts: Vec<bool> = queries.iter().map(|query| query.all).collect();
        let graph = reached(first, limit, |state, next| {
            let may_wait = self.steps(state, next);
            let is_deadlock = next.is_empty() && self.is_deadlock(state);
            next.extend(self.later(state).filter(|_| may_wait));
            let mut values = state.values.clone();
            let mut machine = Machine::new(&self.model.fixed, &mut values);
            machine.is_deadlock = is_deadlock;
            for (query, verdict) in queries.iter().zip(&mut verdicts) {
                if machine.holds(&query.holds) != query.all {
                    *verdict = !query.all;
                }
            }
            self.seen.iter().map(|expr| machine.value(expr)).collect()
        })?;
        let comments = queries.iter().map(|query| query.comment.clone());
        Some(Found { graph, verdicts: comments.zip(verdicts).collect() })
    }
}
