//! Conversions of running codels and tasks that never pause to types of the control plane.

use genom_protocol::{RunningCodel, Spin, Unpaused};
use genom_runtime as runtime;
use genom_supervisor::components;

/// Converts a running codel.
pub(super) fn running(of: &runtime::RunningCodel) -> RunningCodel {
    RunningCodel {
        codel: of.codel.clone(),
        owner: of.owner.clone(),
        task: of.task.clone(),
        for_ns: of.for_ns,
        stuck: of.stuck,
    }
}

/// Converts a task that occupies a processor.
pub(super) fn spin(of: &components::Spin) -> Spin {
    Spin { unpaused: unpaused(&of.unpaused), processor: of.processor }
}

/// Converts a task that never pauses.
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
