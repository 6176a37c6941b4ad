//! Names of owners of codels.

use genom_description::model::{Component, Owner};

/// Name of the task or service that a codel belongs to.
pub(crate) fn owner_name(model: &Component, owner: Owner) -> &str {
    match owner {
        Owner::Task(task) => model.tasks.get(task).map_or("", |task| task.name.as_str()),
        Owner::Service(service) => {
            model.services.get(service).map_or("", |service| service.name.as_str())
        }
    }
}
