//! Cycles without pause in periodic tasks: while one repeats, the task misses its ticks.
//!
//! A cycle is reported only when none of its codels may yield a pause.

use std::collections::HashMap;

use super::Checker;
use crate::diagnostic::{Diagnostic, Severity};
use crate::model::{CodelIx, CodelKind, Component, Dialect, StateIx, Task};

impl Checker {
    /// Warns of such cycles, unless errors leave the component partly unknown.
    pub(super) fn warn_unpaused(&mut self, component: &Component) {
        // In the papers' dialects each state runs at a tick of its own, so none needs a pause.
        let known = self.diagnostics.iter().all(|one| one.severity != Severity::Error);
        if !known || component.dialect != Dialect::Current {
            return;
        }
        for task in &component.tasks {
            self.diagnostics.extend(warning(component, task, &task.codels));
        }
        for service in &component.services {
            if let Some(task) = service.task.and_then(|task| component.tasks.get(task)) {
                self.diagnostics.extend(warning(component, task, &service.codels));
            }
        }
    }
}

/// One state machine that the task runs.
fn warning(component: &Component, task: &Task, codels: &[CodelIx]) -> Option<Diagnostic> {
    task.period?;
    let machine = Machine::new(component, codels);
    let cycle = machine.cycle()?;
    let name = |state: StateIx| component.states.get(state).map_or("", String::as_str);
    let first = component.codels.get(*machine.codel.get(cycle.first()?)?)?;
    let message = match &cycle[..] {
        [state] => format!("state `{}` yields itself without a pause", name(*state)),
        states => {
            let all: Vec<_> = states.iter().map(|state| format!("`{}`", name(*state))).collect();
            format!("states {} follow each other without a pause", all.join(", "))
        }
    };
    let ways: Vec<&str> = machine.ways_out(component, &cycle).into_iter().map(name).collect();
    let (task, again) = (&task.name, name(*cycle.first()?));
    let (code, help) = match ways.first() {
        None => (
            "W0950",
            format!(
                "nothing else follows: task `{task}` never comes to its next tick; yield \
                 `pause::{again}`"
            ),
        ),
        Some(way) => (
            "W0951",
            format!(
                "task `{task}` misses its ticks until a codel yields `{way}`; yield \
                 `pause::{again}` to wait for the next one"
            ),
        ),
    };
    Some(Diagnostic::warning(code, first.span, message).help(help))
}

/// The states of a machine whose codels never pause, with their successors.
struct Machine {
    /// Codel of each state.
    codel: HashMap<StateIx, CodelIx>,
    /// The same states, in the order of the text.
    states: Vec<StateIx>,
    next: HashMap<StateIx, Vec<StateIx>>,
}

impl Machine {
    fn new(component: &Component, codels: &[CodelIx]) -> Self {
        let (mut codel, mut states, mut next) = (HashMap::new(), Vec::new(), HashMap::new());
        for &ix in codels {
            let Some(CodelKind::Fsm { triggers, yields }) =
                component.codels.get(ix).map(|codel| &codel.kind)
            else {
                continue;
            };
            if yields.iter().any(|one| one.pause) {
                continue;
            }
            for &state in triggers {
                codel.insert(state, ix);
                states.push(state);
                next.insert(state, yields.iter().map(|one| one.state).collect::<Vec<_>>());
            }
        }
        for follow in next.values_mut() {
            follow.retain(|state| codel.contains_key(state));
        }
        Self { codel, states, next }
    }

    /// States that form a cycle, if there is one.
    fn cycle(&self) -> Option<Vec<StateIx>> {
        // Removes states without successors, repeatedly: they are in no cycle.
        let mut left: HashMap<StateIx, usize> =
            self.next.iter().map(|(state, follow)| (*state, follow.len())).collect();
        let mut before: HashMap<StateIx, Vec<StateIx>> = HashMap::new();
        for (state, follow) in &self.next {
            follow.iter().for_each(|after| before.entry(*after).or_default().push(*state));
        }
        let mut ends: Vec<StateIx> =
            left.iter().filter(|(_, count)| **count == 0).map(|(state, _)| *state).collect();
        while let Some(end) = ends.pop() {
            left.remove(&end);
            for state in before.get(&end).into_iter().flatten() {
                let Some(count) = left.get_mut(state) else { continue };
                *count -= 1;
                if *count == 0 {
                    ends.push(*state);
                }
            }
        }
        // Every remaining state has a successor: following them must repeat a state.
        let mut way: Vec<StateIx> = Vec::new();
        let mut place: HashMap<StateIx, usize> = HashMap::new();
        let mut state = *self.states.iter().find(|state| left.contains_key(*state))?;
        loop {
            if let Some(begin) = place.insert(state, way.len()) {
                return way.get(begin..).map(<[StateIx]>::to_vec);
            }
            way.push(state);
            state = *self.next.get(&state)?.iter().find(|next| left.contains_key(*next))?;
        }
    }

    /// States outside a cycle that its codels may yield.
    fn ways_out(&self, component: &Component, cycle: &[StateIx]) -> Vec<StateIx> {
        let codels = cycle.iter().filter_map(|state| component.codels.get(*self.codel.get(state)?));
        let yields = codels.filter_map(|codel| match &codel.kind {
            CodelKind::Fsm { yields, .. } => Some(yields),
            CodelKind::Validate | CodelKind::Simple => None,
        });
        yields.flatten().map(|one| one.state).filter(|state| !cycle.contains(state)).collect()
    }
}
