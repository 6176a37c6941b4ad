//! What a task does in the cycle in which it is late.

use crate::action::Action;
use crate::state::State;
use crate::system::System;

/// A part of a cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Spent {
    /// The codel that is executed, or that is to be.
    pub codel: String,
    /// The codels that it waits for; none while it is executed.
    pub awaited: Vec<String>,
    /// How long, in nanoseconds.
    pub ns: u64,
}

/// Where the last cycle of a task begins in a run: with its last tick before the end, or with the run
/// if there is none.
pub(super) fn last_cycle(run: &[(State, Action)], task: u16) -> usize {
    let before = run.split_last().map_or(run, |(_, before)| before);
    before.iter().rposition(|(_, action)| *action == Action::Tick(task)).unwrap_or(0)
}

impl System {
    /// What a task does in the last cycle of a run, of which each step has a date.
    pub(super) fn spent(&self, run: &[(State, Action)], dates: &[u64], task: u16) -> Vec<Spent> {
        let tick = last_cycle(run, task);
        let (after, dates) = (run.iter().skip(tick + 1), dates.windows(2).skip(tick));
        let mut all: Vec<Spent> = Vec::new();
        for ((state, _), date) in after.zip(dates) {
            let ns = date[1].saturating_sub(date[0]);
            let Some((codel, awaited)) = self.doing(state, task).filter(|_| ns > 0) else {
                continue;
            };
            match all.last_mut() {
                Some(last) if (&last.codel, &last.awaited) == (&codel, &awaited) => last.ns += ns,
                _ => all.push(Spent { codel, awaited, ns }),
            }
        }
        all
    }

    /// The codel that a context executes or waits to execute, and those that it waits for.
    fn doing(&self, state: &State, context: u16) -> Option<(String, Vec<String>)> {
        let executed = state.lock.held_by(context).map(|node| (node, Vec::new()));
        let waits =
            || state.lock.awaited_by(context).map(|node| (node, self.ahead(state, context)));
        let (node, ahead) = executed.or_else(waits)?;
        Some((self.node_name(node), ahead))
    }

    /// The codels that a context waits for: those that exclude its own and are executed, or came
    /// before it.
    pub(super) fn ahead(&self, state: &State, context: u16) -> Vec<String> {
        let Some(node) = state.lock.awaited_by(context) else { return Vec::new() };
        let others = state.lock.holders().chain(state.lock.queue.iter().copied());
        let others = others.take_while(|other| *other != (context, node));
        let others = others.filter(|(_, other)| self.conflicts.between(node, *other));
        others.map(|(_, other)| self.node_name(other)).collect()
    }
}
