//! What other contexts may still execute until the next tick of a task.

use super::clocks::Clock;
use super::times::Times;
use crate::action::Answer;
use crate::state::{At, Life, Mode, Run, State};
use crate::system::System;
use genom_timing::Zone;

/// Nodes, by number.
pub(super) type Nodes = Vec<u64>;

/// Whether a node is one of these.
pub(super) fn has(nodes: &Nodes, node: u16) -> bool {
    nodes.get(usize::from(node / 64)).is_some_and(|word| word & (1 << (node % 64)) != 0)
}

fn add(nodes: &mut Nodes, node: u16) {
    if let Some(word) = nodes.get_mut(usize::from(node / 64)) {
        *word |= 1 << (node % 64);
    }
}

/// The nodes that other tasks may execute from here to the next tick of this one; those of workers are
/// not looked at, and all there. A task without a tick until then goes on with what is ready, and with
/// `stop` of what it may be asked to. Activities that interrupt one of this task are taken not to be sent
/// any more, also where that one may be over before the next tick: a cycle without it is shorter.
pub(super) fn still(
    (system, times): (&System, &Times),
    task: u16,
    state: &State,
    (clocks, zone): (&[Clock], &Zone),
) -> Nodes {
    let mut nodes = vec![0; system.plan.nodes().len().div_ceil(64)];
    let place = |task: u16| {
        let at = clocks.iter().position(|clock| *clock == Clock::Tick(task))?;
        Some((at + 1, i64::try_from(system.periods[usize::from(task)]?.period).ok()?))
    };
    let since = |context: u16| {
        let node = state.lock.held_by(context)?;
        let at = clocks.iter().position(|clock| *clock == Clock::Since(context))? + 1;
        Some((at, i64::try_from(times.of(node).most?).ok()?))
    };
    // What ends before the codel that this task executes is not waited for after that.
    let over = |other: u16| {
        let ends = || {
            let ((own, mine), (theirs, length)) = since(task).zip(since(other))?;
            Some(zone.difference(own, theirs)? <= mine - length)
        };
        ends().unwrap_or(false)
    };
    let service = |run: &Run| system.machines[usize::from(run.machine)].service;
    let runs = state.tasks[usize::from(task)].runs.iter().filter(|run| run.end.is_none());
    let mine: Vec<u16> = runs.filter_map(service).collect();
    let sent = |service: u16| {
        system.clients[usize::from(service)]
            && !mine.iter().any(|one| system.interrupts(service, *one))
    };
    for (other, is) in (0u16..).zip(&state.tasks) {
        if other == task {
            continue;
        }
        let begins = is.late || matches!(is.at, At::Begin { tick: true });
        let ticks = || {
            let ((own, period), (theirs, length)) = place(task).zip(place(other))?;
            // The difference of both clocks is the same all the time.
            Some(zone.difference(theirs, own)? > length - period)
        };
        let all = begins || ticks().unwrap_or(true);
        let machines = system.machines.iter().zip(0u16..).filter(|(one, _)| one.task == other);
        for (facts, machine) in machines {
            let runs = || is.runs.iter().chain(&is.inbox).filter(|run| run.machine == machine);
            let requested = facts.service.is_none_or(sent);
            if all && (requested || runs().next().is_some()) {
                let own = facts.codels.iter().flatten().chain(&facts.fetch);
                own.for_each(|node| add(&mut nodes, *node));
            } else if is.at != At::Sleep {
                for (run, at) in is.runs.iter().zip(0u16..).filter(|one| one.0.machine == machine) {
                    let over = match is.at {
                        At::Codel { run, place } if run == at && over(other) => Some(place),
                        _ => None,
                    };
                    goes_on(system, run, over, &mut nodes);
                }
            }
        }
    }
    nodes
}

/// What a run executes in the rest of a cycle.
fn goes_on(system: &System, run: &Run, over: Option<u16>, nodes: &mut Nodes) {
    let facts = &system.machines[usize::from(run.machine)];
    facts.fetch.iter().for_each(|node| add(nodes, *node));
    if run.end.is_some() || matches!(run.life, Life::Init | Life::Cancelled) {
        return;
    }
    let next = |state: u16| {
        let codel = facts.codel(state);
        let answers = codel.map(|codel| &system.codels[usize::from(codel)].answers);
        answers.into_iter().flatten().filter_map(|answer| match answer {
            Answer::Go(state) => Some(*state),
            _ => None,
        })
    };
    let mut left: Vec<u16> = Vec::new();
    for (place, at) in run.places.iter().zip(0u16..).filter(|(place, _)| place.mode == Mode::Ready)
    {
        if Some(at) == over {
            left.extend(next(place.state));
        } else {
            left.push(place.state);
        }
    }
    if run.life == Life::Run && facts.service.is_some() {
        left.push(facts.stop);
    }
    while let Some(state) = left.pop() {
        let Some(codel) = facts.codel(state) else { continue };
        if has(nodes, codel) {
            continue;
        }
        add(nodes, codel);
        left.extend(next(state));
    }
}
