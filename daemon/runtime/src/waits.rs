//! Requests whose outcome a codel cannot wait for, because its own thread would have to produce it.

use genom_description::model::{ServiceIx, ServiceKind};

use crate::engine::Engine;

/// A request that the calling thread must not wait for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CannotWait {
    /// An activity runs when the codel has returned, which waits for it.
    #[error(
        "{instance}/{service} is an activity, and runs on the thread that waits for it (execution = \
         \"single\"): run one of the two components in a cell of its own, or with execution = \
         \"threads\""
    )]
    Activity {
        /// The instance.
        instance: String,
        /// The service.
        service: String,
    },
    /// A codel below on the stack excludes the service, or is serving a request of it.
    #[error(
        "{instance}/{service} conflicts with codel {codel}, which waits for it on the same thread \
         (execution = \"single\")"
    )]
    Conflict {
        /// The instance.
        instance: String,
        /// The service.
        service: String,
        /// The codel that waits.
        codel: String,
    },
}

impl Engine {
    /// See [`Instance::may_wait_here`](crate::Instance::may_wait_here).
    pub(crate) fn may_wait_here(&self, service: ServiceIx) -> Result<(), CannotWait> {
        let plan = &self.shared.plan;
        let Some(model) = plan.component().services.get(service) else { return Ok(()) };
        if !self.single.as_ref().is_some_and(|executor| executor.is_here()) {
            return Ok(());
        }
        let (instance, service_name) = (self.name.clone(), model.name.clone());
        if model.kind == ServiceKind::Activity {
            return Err(CannotWait::Activity { instance, service: service_name });
        }
        let nodes = plan.nodes();
        let ours = model.validates.iter().chain(&model.codels).map(|&codel| nodes.codel(codel));
        let ours: Vec<usize> = ours.chain([nodes.transfer(service)]).collect();
        let busy = self.lock().services[service].busy;
        // In this instance only this thread runs codels, so all of these are below on the stack.
        let below = self.running_codels().into_iter().find(|codel| {
            let node = nodes.codel(codel.place.0);
            busy || ours.iter().any(|&own| nodes.conflicts(own).contains(&node))
        });
        below.map_or(Ok(()), |codel| {
            Err(CannotWait::Conflict { instance, service: service_name, codel: codel.codel })
        })
    }
}
