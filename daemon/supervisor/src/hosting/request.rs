//! A request of a deployment to a service, and its first answer.

use super::{Answer, Components, Hosted, InputError, Rest};
use genom_configuration::CallEntry;
use genom_nearest::suggest;

/// A request was refused.
#[derive(Debug)]
pub struct RequestError {
    /// Where its mistake is: keys from the entry down.
    pub key: Vec<String>,
    /// Why it was refused.
    pub why: String,
}

impl RequestError {
    fn new(key: &[&str], why: String) -> Self {
        Self { key: key.iter().map(|&key| key.to_owned()).collect(), why }
    }
}

/// Sends it; the number of the activity, when it is one. Blocks.
pub fn send(all: &Components, entry: &CallEntry) -> Result<Option<u64>, RequestError> {
    let Some(hosted) = all.get(&entry.component) else {
        let why = format!("{} does not run", entry.component);
        return Err(RequestError::new(&["component"], why));
    };
    send_to(&hosted, entry)
}

/// Sends it to a component at hand. Blocks.
pub fn send_to(hosted: &Hosted, entry: &CallEntry) -> Result<Option<u64>, RequestError> {
    let name = format!("{}/{}", hosted.name, entry.service);
    let services = &hosted.model().services;
    let Some(index) = services.iter().position(|service| service.name == entry.service) else {
        let help = suggest(&entry.service, services.iter().map(|one| one.name.as_str()));
        let why = format!("{} has no service `{}`; {help}", hosted.name, entry.service);
        return Err(RequestError::new(&["service"], why));
    };
    let refused = |error: InputError| {
        let members = error.path.split(['/', '.']).filter(|member| !member.is_empty());
        let key: Vec<&str> = std::iter::once("inputs").chain(members).collect();
        RequestError::new(&key, format!("{name}: {error}"))
    };
    let asked = hosted.asked(index, &entry.inputs, Rest::Kept).map_err(refused)?;
    match hosted.request_blocking(index, asked) {
        Answer::Refused(error) => Err(refused(error)),
        Answer::Accepted(activity) => Ok(Some(activity.number)),
        Answer::HeldUp(error) => Err(RequestError::new(&[], error.to_string())),
        Answer::Gone => Err(RequestError::new(&[], format!("{} stops", hosted.name))),
        Answer::Ended(ending) => match ending.exception() {
            None => Ok(None),
            Some(exception) => {
                Err(RequestError::new(&[], format!("{name} ended with {exception}")))
            }
        },
    }
}
