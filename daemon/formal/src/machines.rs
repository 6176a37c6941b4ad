//! State machines of permanent activities and services, in arrays.

use genom_description::model::{Ix as _, Owner};
use genom_runtime::plan::Plan;

use crate::codels::small;

/// A state machine.
#[derive(Clone, Debug)]
pub struct Machine {
    /// The service; `None` for the permanent activity of a task.
    pub service: Option<u16>,
    /// The task that runs it.
    pub task: u16,
    /// The codel of each state of the component.
    pub codels: Vec<Option<u16>>,
    /// The state in which an activity begins.
    pub start: u16,
    /// The state of an activity that was asked to stop.
    pub stop: u16,
    /// The node of the transfer that reads its outputs at the end, if it has one (dialects.md A).
    pub fetch: Option<u16>,
}

impl Machine {
    /// The codel of a state.
    pub(crate) fn codel(&self, state: u16) -> Option<u16> {
        self.codels.get(usize::from(state)).copied().flatten()
    }
}

pub(crate) fn machines(plan: &Plan) -> Vec<Machine> {
    let one = |machine: &genom_runtime::plan::Machine| {
        let service = match machine.owner {
            Owner::Service(service) => Some(service),
            Owner::Task(_) => None,
        };
        let through = service.filter(|service| plan.services()[*service].through_ids);
        let codels = machine.codels.places();
        Machine {
            service: service.map(|service| small(service.index())),
            task: small(machine.task.index()),
            codels: codels
                .map(|state| machine.codel(state).map(|codel| small(codel.index())))
                .collect(),
            start: small(machine.start.index()),
            stop: small(machine.stop.index()),
            fetch: through.map(|service| small(plan.nodes().transfer(service))),
        }
    };
    plan.machines().iter().map(one).collect()
}
