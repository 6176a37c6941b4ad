//! A request of a deployment to a service, and its first answer.

use crate::config::CallEntry;
use crate::daemon::Daemon;
use crate::hosting::{Answer, Hosted};
use crate::nearest::suggest;

/// Sends it; the number of the activity, when it is one. Blocks.
pub(crate) fn send(daemon: &Daemon, entry: &CallEntry) -> Result<Option<u64>, String> {
    let Some(hosted) = daemon.components.get(&entry.component) else {
        return Err(format!("{} does not run", entry.component));
    };
    send_to(&hosted, entry)
}

/// Sends it to a component at hand. Blocks.
pub(crate) fn send_to(hosted: &Hosted, entry: &CallEntry) -> Result<Option<u64>, String> {
    let name = format!("{}/{}", hosted.name, entry.service);
    let services = &hosted.model().services;
    let Some(index) = services.iter().position(|service| service.name == entry.service) else {
        let help = suggest(&entry.service, services.iter().map(|one| one.name.as_str()));
        return Err(format!("{} has no service `{}`; {help}", hosted.name, entry.service));
    };
    let input = hosted.input(index, &entry.inputs).map_err(|error| format!("{name}: {error}"))?;
    match hosted.request_blocking(index, input) {
        Answer::Accepted(activity) => Ok(Some(activity.number)),
        Answer::Gone => Err(format!("{} stops", hosted.name)),
        Answer::Ended(ending) => match ending.exception() {
            None => Ok(None),
            Some(exception) => Err(format!("{name} ended with {exception}")),
        },
    }
}
