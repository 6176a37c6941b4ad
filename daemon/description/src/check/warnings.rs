//! Warnings of what GenoM3 accepts silently and is probably a mistake (genom3.md 3.10).

use std::collections::{HashMap, HashSet};

use super::Checker;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{
    Codel, CodelIx, CodelKind, Component, Direction, Owner, PathStep, Service, ServiceKind, Source,
    Span, StateIx,
};

impl Checker {
    pub(super) fn warn(&mut self, component: &Component) {
        // An error may be the reason why something seems unused: no warnings then.
        if self.diagnostics.errors() > 0 {
            return;
        }
        warn_directions(component, &mut self.diagnostics);
        warn_unused(component, &mut self.diagnostics);
        warn_endless(component, &mut self.diagnostics);
    }
}

/// Warns of `out` on a parameter that is only an input of the service when no codel reads it
/// afterwards: what is written is lost. Parameters keep their values from codel to codel, so an
/// activity may count in one.
fn warn_directions(component: &Component, out: &mut Diagnostics) {
    for (ix, codel) in component.codels.pairs() {
        // A validate codel may edit the value it checks (genom3.md 7.3).
        let (Owner::Service(rank), false) =
            (codel.owner, matches!(codel.kind, CodelKind::Validate))
        else {
            continue;
        };
        let Some(service) = component.services.get(rank) else { continue };
        let mut later = None;
        for parameter in &codel.parameters {
            let Source::Parameter { index, path } = &parameter.source else { continue };
            let Some(declared) = service.parameters.get(*index) else { continue };
            if declared.direction == Direction::In && parameter.direction != Direction::In {
                let later = later.get_or_insert_with(|| run_later(component, service, ix));
                if later.iter().any(|codel| reads(codel, *index, path)) {
                    continue;
                }
                let message = format!(
                    "`{}` is `in` for the service: what codel `{}` writes is lost",
                    declared.name, codel.name
                );
                out.push(
                    Diagnostic::warning("W0902", parameter.span, message)
                        .note(declared.span, "declared here"),
                );
            }
        }
    }
}

/// Codels of a service that may run after another one, including itself if it can run again.
fn run_later<'m>(component: &'m Component, service: &Service, before: CodelIx) -> Vec<&'m Codel> {
    let all = || service.codels.iter().filter_map(|rank| component.codels.get(*rank));
    let Some(CodelKind::Fsm { yields, .. }) = component.codels.get(before).map(|codel| &codel.kind)
    else {
        // Simple codels run one after the other.
        let after = service.codels.iter().skip_while(|rank| **rank != before).skip(1);
        return after.filter_map(|rank| component.codels.get(*rank)).collect();
    };
    // Also the `stop` codel, after an interruption, and those of external events.
    let stop = component.state("stop");
    let sinks = component.sinks.iter().map(|sink| sink.state);
    let mut todo: Vec<StateIx> = yields.iter().map(|y| y.state).chain(stop).chain(sinks).collect();
    let mut reached: HashSet<StateIx> = todo.iter().copied().collect();
    let mut later = Vec::new();
    while let Some(state) = todo.pop() {
        for codel in all() {
            let CodelKind::Fsm { triggers, yields } = &codel.kind else { continue };
            if triggers.contains(&state) {
                todo.extend(yields.iter().map(|y| y.state).filter(|next| reached.insert(*next)));
                later.push(codel);
            }
        }
    }
    later
}

/// Whether a codel reads what another one wrote into a parameter of the service.
fn reads(codel: &Codel, parameter: usize, written: &[PathStep]) -> bool {
    codel.parameters.iter().any(|read| {
        let Source::Parameter { index, path } = &read.source else { return false };
        let overlaps = path.iter().zip(written).all(|(a, b)| a == b);
        *index == parameter && read.direction != Direction::Out && overlaps
    })
}

fn warn_unused(component: &Component, out: &mut Diagnostics) {
    let mut ports = HashSet::new();
    let mut tasks = HashSet::new();
    for codel in &component.codels {
        ports.extend(codel.parameters.iter().filter_map(|p| match p.source {
            Source::Port(port) => Some(port),
            _ => None,
        }));
        if let Owner::Task(task) = codel.owner {
            tasks.insert(task);
        }
    }
    tasks.extend(component.services.iter().filter_map(|service| service.task));
    for (ix, port) in component.ports.pairs() {
        // The runtime writes this port.
        if port.name != "genom_state" && !ports.contains(&ix) {
            let message = format!("no codel uses port `{}`", port.name);
            out.push(Diagnostic::warning("W0903", port.span, message));
        }
    }
    for (ix, task) in component.tasks.pairs() {
        if !tasks.contains(&ix) {
            let message = format!("nothing runs in task `{}`", task.name);
            out.push(Diagnostic::warning("W0905", task.span, message));
        }
    }
}

/// Warns of an activity that may run endlessly without a `stop` codel: an interruption then ends it
/// at once.
fn warn_endless(component: &Component, out: &mut Diagnostics) {
    for service in component.services.iter().filter(|s| s.kind == ServiceKind::Activity) {
        let mut next: HashMap<StateIx, Vec<StateIx>> = HashMap::new();
        for codel in service.codels.iter().filter_map(|rank| component.codels.get(*rank)) {
            let CodelKind::Fsm { triggers, yields } = &codel.kind else { continue };
            for trigger in triggers {
                next.entry(*trigger).or_default().extend(yields.iter().map(|y| y.state));
            }
        }
        let stops = component.state("stop").is_some_and(|stop| next.contains_key(&stop));
        let loops = component.state("start").is_some_and(|start| has_cycle(&next, start));
        if stops || !loops {
            continue;
        }
        let message = format!("activity `{}` loops and has no codel<stop>", service.name);
        let span: Span = service.span;
        out.push(Diagnostic::warning("W0906", span, message).help(
            "interrupted, it ends at once with `genom::interrupted`: add codel<stop> to end well",
        ));
    }
}

/// Whether a cycle can be reached from `start`.
fn has_cycle(next: &HashMap<StateIx, Vec<StateIx>>, start: StateIx) -> bool {
    // Depth first, without recursion. Open states are on the current path; finished ones lead to no
    // cycle.
    let mut open = HashSet::from([start]);
    let mut done = HashSet::new();
    let mut way = vec![(start, 0)];
    while let Some((state, rank)) = way.last_mut() {
        match next.get(state).and_then(|list| list.get(*rank)) {
            None => {
                open.remove(state);
                done.insert(*state);
                way.pop();
            }
            Some(&to) => {
                *rank += 1;
                if open.contains(&to) {
                    return true;
                }
                if !done.contains(&to) {
                    open.insert(to);
                    way.push((to, 0));
                }
            }
        }
    }
    false
}
