//! State machines: the codel of each state, and the effect of each returned event.

use genom_description::model::{CodelKind, Component, Owner, TaskIx};

use super::event::{Event, Meaning};

/// The state machine of a task's permanent activity or of a service.
#[derive(Debug)]
pub struct Machine {
    /// The task or service it belongs to.
    pub owner: Owner,
    /// The task that runs it.
    pub task: TaskIx,
    /// The codel of each state, if it has one.
    pub codels: Box<[Option<u16>]>,
    /// State `start`.
    pub start: u16,
    /// State `stop`.
    pub stop: u16,
}

/// Effect of a returned event (genom3.md 7.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transition {
    /// Go to this state, which runs in the next pass.
    Go(u16),
    /// Go to this state after a pause.
    Pause(u16),
    /// `ether`: the token is removed.
    End,
    /// `sleep`: the token waits for an external event or for `stop` (dialects.md A).
    Sleep(u16),
    /// A declared exception: ends the activity.
    Throw,
    /// An event that this codel must not return.
    Bad,
}

impl Machine {
    /// The codel of a state.
    #[must_use]
    pub fn codel(&self, state: u16) -> Option<usize> {
        self.codels.get(usize::from(state)).copied().flatten().map(usize::from)
    }
}

/// Machines of permanent activities by task, then of services that have a task.
pub(super) fn machines(model: &Component) -> Vec<Machine> {
    let state = |name: &str| {
        let found = model.states.iter().position(|state| state == name);
        found.and_then(|state| u16::try_from(state).ok()).unwrap_or(u16::MAX)
    };
    let machine = |owner, task, codels: &[usize]| {
        let mut table = vec![None; model.states.len()];
        for &codel in codels {
            let CodelKind::Fsm { triggers, .. } = &model.codels[codel].kind else { continue };
            for &trigger in triggers {
                if let Some(slot) = table.get_mut(trigger) {
                    *slot = u16::try_from(codel).ok();
                }
            }
        }
        Machine { owner, task, codels: table.into(), start: state("start"), stop: state("stop") }
    };
    let permanent = model.tasks.pairs();
    let permanent = permanent.map(|(ix, task)| machine(Owner::Task(ix), ix, &task.codels));
    let services = model.services.pairs().filter_map(|(ix, service)| {
        Some(machine(Owner::Service(ix), service.task?, &service.codels))
    });
    permanent.chain(services).collect()
}

/// Effects of all events for each codel; empty for codels outside state machines.
pub(super) fn transitions(
    model: &Component,
    events: &[Event],
    machines: &[Machine],
) -> Vec<Box<[Transition]>> {
    let of_codel = |rank: usize| -> Box<[Transition]> {
        let codel = &model.codels[rank];
        let CodelKind::Fsm { yields, .. } = &codel.kind else { return Box::default() };
        let throws = match codel.owner {
            Owner::Task(task) => model.tasks.get(task).map(|task| &task.throws),
            Owner::Service(service) => model.services.get(service).map(|service| &service.throws),
        };
        let machine = machines.iter().find(|machine| machine.owner == codel.owner);
        let transition = |event: &Event| match event.meaning {
            Meaning::State { state, pause } => {
                let allowed = yields.iter().any(|y| y.state == state && y.pause == pause);
                let name = model.states.get(state).map_or("", String::as_str);
                let runs =
                    machine.is_some_and(|m| m.codels.get(state).is_some_and(Option::is_some));
                let number = u16::try_from(state).unwrap_or(u16::MAX);
                match (allowed, name) {
                    (false, _) => Transition::Bad,
                    (true, "ether") => Transition::End,
                    // The component may have a state of its own named `sleep`.
                    (true, "sleep") if !runs => Transition::Sleep(number),
                    (true, _) if pause => Transition::Pause(number),
                    (true, _) => Transition::Go(number),
                }
            }
            Meaning::Exception(Some(id)) if throws.is_some_and(|throws| throws.contains(&id)) => {
                Transition::Throw
            }
            Meaning::Exception(_) => Transition::Bad,
        };
        events.iter().map(transition).collect()
    };
    (0..model.codels.len()).map(of_codel).collect()
}
