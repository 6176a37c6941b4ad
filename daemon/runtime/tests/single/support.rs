//! Components of tests whose tasks share a thread.

use std::sync::Arc;

use genom_runtime::{Execution, Executor, Instance};

#[path = "../support/closures.rs"]
pub(crate) mod closures;
#[path = "../support/plan.rs"]
mod plan;

use closures::Closures;
pub(crate) use plan::plan;

/// What executes the components of a test that does not choose itself: a thread for each component.
pub(crate) fn execution() -> Execution {
    Execution::Single(shared())
}

/// An executor for several components.
pub(crate) fn shared() -> Arc<Executor> {
    Arc::new(Executor::new("tasks"))
}

/// Starts a component on an executor.
#[track_caller]
pub(crate) fn start_on(executor: &Arc<Executor>, name: &str, body: &Arc<Closures>) -> Instance {
    body.start_with(|options| {
        options.name = name.to_owned();
        options.execution = Execution::Single(Arc::clone(executor));
        options.stuck_after = std::time::Duration::from_millis(50);
    })
}
