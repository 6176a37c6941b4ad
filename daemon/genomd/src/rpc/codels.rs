//! Codels that keep others from working, as the control plane tells of them.

use genom_protocol::{RunningCodel, Spin, Unpaused};
use genom_runtime as runtime;
use genom_supervisor::components;

/// A codel that runs, as it is told.
pub(super) fn running(of: &runtime::RunningCodel) -> RunningCodel {
    RunningCodel {
        codel: of.codel.clone(),
        owner: of.owner.clone(),
        task: of.task.clone(),
        for_ns: of.for_ns,
        stuck: of.stuck,
    }
}

/// A task that keeps a processor, as it is told.
pub(super) fn spin(of: &components::Spin) -> Spin {
    Spin { unpaused: unpaused(&of.unpaused), processor: of.processor }
}

/// A task that does not pause, as it is told.
pub(super) fn unpaused(of: &runtime::Unpaused) -> Unpaused {
    Unpaused {
        task: of.task.clone(),
        periodic: of.periodic,
        codel: of.codel.clone(),
        owner: of.owner.clone(),
        for_ns: of.for_ns,
        steps: of.steps,
    }
}
