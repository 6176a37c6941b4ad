//! Requests to services by name, for deployments and for programs that use this crate.

use std::sync::Arc;

use genom_configuration::CallEntry;
use genom_nearest::suggest;
use serde_json::Value;

use super::activities::Activity;
use super::hosted::{Answer, Hosted};
use super::input::{InputError, Rest};
use super::running::Components;
use crate::outcome::Outcome;
use genom_bus::{Bus, Change};

/// Why a request was refused.
#[derive(Debug, thiserror::Error)]
#[error("{why}")]
pub struct RequestError {
    /// Keys from the entry of the deployment to the mistake.
    pub key: Vec<String>,
    /// The reason, as a sentence.
    pub why: String,
}

impl RequestError {
    fn new(key: &[&str], why: String) -> Self {
        Self { key: key.iter().map(|&key| key.to_owned()).collect(), why }
    }
}

/// Sends a request. Returns the number of the activity, if it is one. Blocks.
pub fn send(all: &Components, entry: &CallEntry) -> Result<Option<u64>, RequestError> {
    let Some(hosted) = all.get(&entry.component) else {
        let why = format!("{} does not run", entry.component);
        return Err(RequestError::new(&["component"], why));
    };
    send_to(&hosted, entry)
}

/// Sends a request to the given component. Blocks.
pub fn send_to(hosted: &Hosted, entry: &CallEntry) -> Result<Option<u64>, RequestError> {
    match ask(hosted, &entry.service, &entry.inputs)? {
        First::Accepted(activity) => Ok(Some(activity.number)),
        First::Ended(outcome) => match outcome.exception() {
            None => Ok(None),
            Some(exception) => {
                let (instance, service) = (&hosted.name, &entry.service);
                let why = format!("{instance}/{service} ended with {exception}");
                Err(RequestError::new(&[], why))
            }
        },
    }
}

/// Fires an external event.
pub fn fire(all: &Components, bus: &Bus, name: &str, event: &str) -> Result<(), RequestError> {
    let Some(hosted) = all.get(name) else {
        return Err(RequestError::new(&["component"], format!("{name} does not run")));
    };
    let sinks = &hosted.model().sinks;
    let Some(index) = sinks.iter().position(|sink| sink.name == event) else {
        let help = suggest(event, sinks.iter().map(|sink| sink.name.as_str()));
        let why = format!("{name} has no event `{event}`; {help}");
        return Err(RequestError::new(&["event"], why));
    };
    hosted.fire(index);
    bus.tell(&Change::EventFired { component: name.to_owned(), name: event.to_owned() });
    Ok(())
}

impl Hosted {
    /// Calls a service and waits for its outcome, also that of an activity. Blocks.
    ///
    /// Inputs that are left out keep their present values if the service is an attribute; otherwise
    /// they take their defaults.
    ///
    /// # Errors
    /// There is no such service, the inputs are not valid, or a stuck codel blocks the request.
    /// Nothing was executed.
    pub fn call(&self, service: &str, inputs: &Value) -> Result<Outcome, RequestError> {
        let stopped = || RequestError::new(&[], format!("{} stops", self.name));
        match ask(self, service, inputs)? {
            First::Ended(outcome) => Ok(outcome),
            First::Accepted(activity) => activity.wait().ok_or_else(stopped),
        }
    }
}

/// The first reply to a request.
enum First {
    Ended(Outcome),
    Accepted(Arc<Activity>),
}

fn ask(hosted: &Hosted, service: &str, inputs: &Value) -> Result<First, RequestError> {
    let services = &hosted.model().services;
    let Some(index) = services.find(|one| one.name == service) else {
        let help = suggest(service, services.iter().map(|one| one.name.as_str()));
        let why = format!("{} has no service `{service}`; {help}", hosted.name);
        return Err(RequestError::new(&["service"], why));
    };
    let refused = |error: InputError| {
        let members = error.path.split(['/', '.']).filter(|member| !member.is_empty());
        let key: Vec<&str> = std::iter::once("inputs").chain(members).collect();
        RequestError::new(&key, format!("{}/{service}: {error}", hosted.name))
    };
    let asked = hosted.asked(index, inputs, Rest::Kept).map_err(refused)?;
    match hosted.request_blocking(index, asked) {
        Answer::Refused(error) => Err(refused(error)),
        Answer::Accepted(activity) => Ok(First::Accepted(activity)),
        Answer::HeldUp(error) => Err(RequestError::new(&[], error.to_string())),
        Answer::Gone => Err(RequestError::new(&[], format!("{} stops", hosted.name))),
        Answer::Ended(outcome) => Ok(First::Ended(outcome)),
    }
}
