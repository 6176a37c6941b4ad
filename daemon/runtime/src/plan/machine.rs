//! State machines: the codel of each state, and the effect of each returned event.

use genom_description::model::{
    Codel, CodelIx, CodelKind, Component, Indexed, Owner, StateIx, TaskIx,
};

use super::error::PlanError;
use super::event::{Event, Meaning};
use super::ix16::Ix16;

/// The state machine of a task's permanent activity or of a service.
#[derive(Debug)]
pub struct Machine {
    /// The task or service it belongs to.
    pub owner: Owner,
    /// The task that runs it.
    pub task: TaskIx,
    /// The codel of each state, if it has one.
    pub codels: Indexed<StateIx, Option<Ix16<CodelIx>>>,
    /// State `start`.
    pub start: StateIx,
    /// State `stop`.
    pub stop: StateIx,
}

/// Effect of a returned event (genom3.md 7.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transition {
    /// Go to this state, which runs in the next pass.
    Go(Ix16<StateIx>),
    /// Go to this state after a pause.
    Pause(Ix16<StateIx>),
    /// `ether`: the token is removed.
    End,
    /// `sleep`: the token waits for an external event or for `stop` (dialects.md A).
    Sleep(Ix16<StateIx>),
    /// A declared exception: ends the activity.
    Throw,
    /// An event that this codel must not return.
    Bad,
}

// Tables hold one for each codel and event, so it stays small.
const _: () = assert!(size_of::<Transition>() == 4);

impl Machine {
    /// The codel of a state.
    #[must_use]
    #[inline]
    pub fn codel(&self, state: StateIx) -> Option<CodelIx> {
        self.codels.get(state).copied().flatten().map(Ix16::ix)
    }
}

/// Machines of permanent activities by task, then of services that have a task.
pub(super) fn machines(model: &Component) -> Result<Vec<Machine>, PlanError> {
    let state = |name: &str| {
        let (component, what) = (model.name.clone(), format!("there is no state `{name}`"));
        model.state(name).ok_or(PlanError::Inconsistent { component, what })
    };
    let (start, stop) = (state("start")?, state("stop")?);
    let machine = |owner, task, codels: &[CodelIx]| {
        let mut table = model.states.map(|_, _| None);
        for &codel in codels {
            let CodelKind::Fsm { triggers, .. } = &model.codels[codel].kind else { continue };
            for &trigger in triggers {
                if let Some(slot) = table.get_mut(trigger) {
                    // All codels have one: their number was checked.
                    *slot = Ix16::new(codel);
                }
            }
        }
        Machine { owner, task, codels: table, start, stop }
    };
    let permanent = model.tasks.pairs();
    let permanent = permanent.map(|(ix, task)| machine(Owner::Task(ix), ix, &task.codels));
    let services = model.services.pairs().filter_map(|(ix, service)| {
        Some(machine(Owner::Service(ix), service.task?, &service.codels))
    });
    Ok(permanent.chain(services).collect())
}

/// Effects of all events for each codel; empty for codels outside state machines.
pub(super) fn transitions(
    model: &Component,
    events: &[Event],
    machines: &[Machine],
) -> Indexed<CodelIx, Box<[Transition]>> {
    let of_codel = |codel: &Codel| -> Box<[Transition]> {
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
                let runs = machine.is_some_and(|machine| machine.codel(state).is_some());
                // All states have one: each is an event, and those were counted.
                let Some(to) = Ix16::new(state) else { return Transition::Bad };
                match (allowed, name) {
                    (false, _) => Transition::Bad,
                    (true, "ether") => Transition::End,
                    // The component may have a state of its own named `sleep`.
                    (true, "sleep") if !runs => Transition::Sleep(to),
                    (true, _) if pause => Transition::Pause(to),
                    (true, _) => Transition::Go(to),
                }
            }
            Meaning::Exception(Some(id)) if throws.is_some_and(|throws| throws.contains(&id)) => {
                Transition::Throw
            }
            Meaning::Exception(_) => Transition::Bad,
        };
        events.iter().map(transition).collect()
    };
    model.codels.iter().map(of_codel).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use genom_description::model::{CodelIx, Ix as _};
    use genom_description::{Options, read_text};

    use super::super::{Plan, PlanError};

    #[test]
    fn a_component_with_more_codels_than_a_machine_can_refer_to_is_refused() {
        let text = "component c {
            task t { period 5 ms; };
            activity a() { task t; codel<start> s() yield ether; };
        };";
        let analysis = read_text("c.gen", text, &Options::default());
        assert!(!analysis.has_errors(), "{:?}", analysis.diagnostics);
        let mut specification = analysis.specification;
        let codels = &mut specification.components[0].codels;
        let one = codels[CodelIx::new(0)].clone();
        while codels.len() <= 1 << 16 {
            codels.push(one.clone());
        }
        let refused = Plan::new(&Arc::new(specification), 0).unwrap_err();
        assert!(matches!(refused, PlanError::TooManyCodels { count: 65_537, .. }), "{refused}");
    }
}
