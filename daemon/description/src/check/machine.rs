//! State machines: every state that is yielded has a codel, every codel can be reached (genom3.md
//! 3.7 K7 to K11).

use std::collections::{HashMap, HashSet};

use super::Checker;
use super::state::{BodyId, CodelState};
use crate::diagnostic::Diagnostic;
use crate::model::{Dialect, Ix as _, Span, StateIx};
use crate::syntax::ServiceKind;

impl Checker {
    /// Checks an activity of a component.
    // genom3.md 3.6 S13, S14.
    pub(super) fn check_activity(&mut self, id: BodyId, rank: usize) {
        let Some((_, service)) = self.bodies[id].services.get_index_mut(rank) else { return };
        if service.kind != ServiceKind::Activity || self.lost.contains(&service.name) {
            return;
        }
        let (name, span, broken) = (service.name.clone(), service.span, service.broken);
        let codels = std::mem::take(&mut service.codels);
        if service.task.is_none() && !broken {
            let help = match self.bodies[id].tasks.keys().next() {
                Some(task) => format!("write `task {task};` in it"),
                None => "declare a task, and write `task NAME;` in the activity".to_owned(),
            };
            let message = format!("activity `{name}` runs in no task");
            self.push(Diagnostic::error("E0613", span, message).help(help));
        }
        if codels.is_empty() {
            if !broken {
                let message = format!("activity `{name}` has no codel<start>");
                self.push(
                    Diagnostic::error("E0614", span, message)
                        .help("an activity begins with `codel<start>`"),
                );
            }
            return;
        }
        self.check_machine(id, &codels, Some((&name, span)));
        if let Some((_, service)) = self.bodies[id].services.get_index_mut(rank) {
            service.codels = codels;
        }
    }

    pub(super) fn check_task_machine(&mut self, id: BodyId, rank: usize) {
        let Some((_, task)) = self.bodies[id].tasks.get_index_mut(rank) else { return };
        let codels = std::mem::take(&mut task.codels);
        self.check_machine(id, &codels, None);
        if let Some((_, task)) = self.bodies[id].tasks.get_index_mut(rank) {
            task.codels = codels;
        }
    }

    /// Whether a state needs no codel: `ether`, and `sleep` where there are external events.
    fn is_final(&self, id: BodyId, state: StateIx) -> bool {
        let body = &self.bodies[id];
        match body.states.get_index(state.index()).map(|(name, _)| &**name) {
            Some("ether") => true,
            // dialects.md A.
            Some("sleep") => body.dialect != Dialect::Current || !body.sinks.is_empty(),
            _ => false,
        }
    }

    fn check_machine(&mut self, id: BodyId, codels: &[CodelState], activity: Option<(&str, Span)>) {
        let mut by_state: HashMap<StateIx, usize> = HashMap::new();
        for (rank, codel) in codels.iter().enumerate() {
            for &state in &codel.triggers {
                let Some(&other) = by_state.get(&state) else {
                    by_state.insert(state, rank);
                    continue;
                };
                // K7.
                let message = format!("state `{}` already has a codel", self.state_name(id, state));
                self.push(
                    Diagnostic::error("E0707", codel.syntax.name.span, message)
                        .note(codels[other].syntax.name.span, "this one"),
                );
            }
        }
        let named = |name: &str| self.bodies[id].states.get_index_of(name).map(StateIx::new);
        let (ether, start, stop) = (named("ether"), named("start"), named("stop"));
        let has = |state: Option<StateIx>| state.filter(|state| by_state.contains_key(state));
        let (start, stop) = (has(start), has(stop));
        let sinks: Vec<StateIx> =
            self.bodies[id].sinks.keys().copied().filter(|s| by_state.contains_key(s)).collect();
        // K8.
        if let (Some((name, span)), None) = (activity, start) {
            let message = format!("activity `{name}` has no codel<start>");
            self.push(
                Diagnostic::error("E0708", span, message)
                    .help("an activity begins with `codel<start>`"),
            );
        }
        let count = self.diagnostics.found();
        let roots: Vec<StateIx> =
            start.into_iter().chain(stop).chain(sinks.iter().copied()).collect();
        let reached = reach(&roots, codels, &by_state);
        self.check_yields(id, codels, &by_state, &reached);
        // A misspelt state also makes its codel unreachable: only the misspelling is reported.
        if self.diagnostics.found() == count && (activity.is_none() || start.is_some()) {
            self.check_reached(id, codels, &reached);
        }
        // Which states a missing codel would yield is unknown.
        let Some(ether) = ether.filter(|_| self.diagnostics.found() == count) else { return };
        // K10.
        if let Some(stop) = stop
            && !reach(&[stop], codels, &by_state).contains(&ether)
            && !self.dead_end(id, codels)
        {
            let span = codels[by_state[&stop]].syntax.name.span;
            let message = "codel<stop> can never come to `ether`";
            self.push(
                Diagnostic::error("E0710", span, message)
                    .help("let a codel that follows it yield `ether`"),
            );
        }
        // genom3.md 3.10: GenoM3 accepts it.
        if let (Some((name, span)), Some(start)) = (activity, start) {
            let alive: Vec<StateIx> = std::iter::once(start).chain(sinks).collect();
            if !reach(&alive, codels, &by_state).contains(&ether) && !self.dead_end(id, codels) {
                let message =
                    format!("activity `{name}` can never end by itself: no way to `ether`");
                self.push(Diagnostic::warning("W0901", span, message));
            }
        }
    }

    /// Whether a yield, or the codel of a yielded state, was refused.
    fn dead_end(&self, id: BodyId, codels: &[CodelState]) -> bool {
        codels.iter().any(|codel| {
            let written = codel.syntax.machine.as_ref().map_or(0, |(_, yields)| yields.len());
            written != codel.yields.len()
                || codel.yields.iter().any(|y| self.lost.contains(self.state_name(id, y.state)))
        })
    }

    // genom3.md 3.7 K9.
    fn check_yields(
        &mut self,
        id: BodyId,
        codels: &[CodelState],
        by_state: &HashMap<StateIx, usize>,
        reached: &HashSet<StateIx>,
    ) {
        let mut said: HashSet<StateIx> = HashSet::new();
        for codel in codels {
            if !codel.triggers.iter().any(|state| reached.contains(state)) {
                continue;
            }
            for next in &codel.yields {
                if by_state.contains_key(&next.state)
                    || self.is_final(id, next.state)
                    || !said.insert(next.state)
                {
                    continue;
                }
                let name = self.state_name(id, next.state).to_owned();
                if self.lost.contains(&*name) {
                    continue;
                }
                let span = codel
                    .syntax
                    .machine
                    .as_ref()
                    .and_then(|(_, yields)| yields.iter().find(|e| *e.name.text == *name))
                    .map_or(codel.syntax.name.span, |event| event.name.span);
                let near = by_state.keys().map(|state| self.state_name(id, *state));
                let near = genom_nearest::meant(&name, near);
                let message = format!("state `{name}` has no codel");
                let mut error = Diagnostic::error("E0709", span, message);
                error.help =
                    near.or_else(|| Some(format!("add `codel<{name}>`, or yield `ether` to end")));
                self.push(error);
            }
        }
    }

    /// Reports codels that cannot be reached. A codel with several states is reached if one of them
    /// is.
    // genom3.md 3.7 K11.
    fn check_reached(&mut self, id: BodyId, codels: &[CodelState], reached: &HashSet<StateIx>) {
        for codel in codels {
            let Some(&first) = codel.triggers.first() else { continue };
            if codel.triggers.iter().any(|state| reached.contains(state)) {
                continue;
            }
            let written = codel.syntax.machine.as_ref().map_or(&[][..], |(triggers, _)| triggers);
            let name = self.state_name(id, first);
            let event = written.iter().find(|event| *event.name.text == *name);
            let span = event.or(written.first()).map_or(codel.syntax.name.span, |e| e.name.span);
            let (message, whom) = if codel.triggers.len() == 1 {
                (format!("state `{name}` is never reached"), "it")
            } else {
                let names: Vec<_> = codel
                    .triggers
                    .iter()
                    .map(|state| format!("`{}`", self.state_name(id, *state)))
                    .collect();
                let codel = &codel.syntax.name.text;
                let message = format!(
                    "codel `{codel}` is never reached, by none of its states {}",
                    names.join(", ")
                );
                (message, "one of them")
            };
            let help = if self.bodies[id].dialect == Dialect::Current {
                format!("no codel that start or stop leads to yields {whom}")
            } else {
                format!("declare `event {name};` if it comes from outside")
            };
            self.push(Diagnostic::error("E0711", span, message).help(help));
        }
    }

    /// In the 2011 dialect, a state that has a codel but is never yielded is an external event.
    // dialects.md B.
    pub(super) fn declare_sinks_by_use(&mut self, id: BodyId) {
        let body = &self.bodies[id];
        let codels = || {
            let tasks = body.tasks.values().flat_map(|task| &task.codels);
            tasks.chain(body.services.values().flat_map(|service| &service.codels))
        };
        let yielded: HashSet<StateIx> = codels().flat_map(|c| &c.yields).map(|y| y.state).collect();
        let mut fresh: Vec<(StateIx, Span)> = Vec::new();
        for codel in codels() {
            for &state in &codel.triggers {
                let name = self.state_name(id, state);
                if matches!(name, "ether" | "start" | "stop") || yielded.contains(&state) {
                    continue;
                }
                if let Some((_, span)) = body.states.get_index(state.index()) {
                    fresh.push((state, *span));
                }
            }
        }
        for (state, span) in fresh {
            self.bodies[id].sinks.entry(state).or_insert(span);
        }
    }

    pub(super) fn state_name(&self, id: BodyId, state: StateIx) -> &str {
        self.bodies[id].states.get_index(state.index()).map_or("", |(name, _)| name)
    }
}

/// All states that can be reached from `roots`, including these.
pub(super) fn reach(
    roots: &[StateIx],
    codels: &[CodelState],
    by_state: &HashMap<StateIx, usize>,
) -> HashSet<StateIx> {
    let mut reached: HashSet<StateIx> = roots.iter().copied().collect();
    let mut todo = roots.to_vec();
    while let Some(state) = todo.pop() {
        let Some(codel) = by_state.get(&state).and_then(|rank| codels.get(*rank)) else { continue };
        for next in &codel.yields {
            if reached.insert(next.state) {
                todo.push(next.state);
            }
        }
    }
    reached
}
