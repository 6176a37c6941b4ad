//! Computes the steps from what runs to a deployment.

use std::path::PathBuf;

use genom_nearest::suggest;
use serde_json::Value;

use super::step::Step;
use crate::components::{Components, Hosted};
use crate::connections::Connections;
use crate::ties::Connection;
use genom_configuration::{
    BackendNames, CallEntry, ConnectionEntry, Deployment, LoadRequest, Spot,
};
use genom_finder::locate;

/// Why there are no such steps: the deployment contradicts itself or what runs. Nothing was
/// changed.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum Contradiction {
    /// The `after` of components form a circle.
    #[error("{0} comes after itself: look at the `after` of the components")]
    Circle(String),
    /// A name that does not exist.
    #[error("{what} names component `{typed}`, which neither runs nor is deployed; {help}")]
    Unknown { what: String, typed: String, help: String, place: Spot },
    /// Two components have the same name.
    #[error("two components are named {0}: give one another `name`")]
    Twice(String),
    /// A running component cannot become what is wanted.
    #[error(
        "{name} runs from another library than the deployment says: `genomctl unload {name}` first"
    )]
    Other { name: String, place: Spot },
}

impl Contradiction {
    /// The entry of the file that is wrong.
    pub fn place(&self) -> Spot {
        match self {
            Contradiction::Unknown { place, .. } | Contradiction::Other { place, .. } => {
                place.clone()
            }
            _ => Spot::default(),
        }
    }
}

/// The steps from what runs to a deployment.
#[derive(Debug, Default)]
pub struct Steps {
    /// The steps in order; empty if everything is as wanted.
    pub to_take: Vec<Step>,
    /// Steps that remove what the deployment does not contain. With `prune` they are in `steps`,
    /// too.
    pub beside: Vec<Step>,
}

/// The part of the running system that steps depend on.
#[derive(Clone, Copy)]
pub(super) struct Present<'a> {
    pub(super) components: &'a Components,
    pub(super) connections: &'a Connections,
    /// Default middleware, for components that name none.
    pub(super) backend: &'a str,
    /// The component path.
    pub(super) path: &'a [PathBuf],
}

/// Computes the steps. With `prune`, what the deployment does not contain is removed.
pub(super) fn steps(
    present: Present<'_>,
    wanted: &Deployment,
    prune: bool,
) -> Result<Steps, Contradiction> {
    let beside = beside(present.components, wanted);
    let mut to_take = wanted_steps(present, wanted, prune)?;
    if prune {
        let (leave, cut): (Vec<_>, Vec<_>) =
            beside.iter().cloned().partition(|step| matches!(step, Step::Unload(_)));
        to_take.splice(0..0, cut);
        to_take.extend(leave);
    }
    Ok(Steps { to_take, beside })
}

/// The steps that remove what the deployment does not contain: first connections, then components,
/// each before those it uses.
fn beside(components: &Components, wanted: &Deployment) -> Vec<Step> {
    let mut all = components.all();
    all.reverse();
    let said = |name: &str| wanted.component.iter().any(|one| one.instance() == name);
    let declared =
        |entry: &ConnectionEntry| wanted.connection.iter().any(|one| one.inport == entry.inport);
    let cut = all.iter().filter(|hosted| said(&hosted.name)).flat_map(|hosted| {
        let entries = entries(hosted).into_iter();
        entries.filter(|entry| !declared(entry)).map(Step::Disconnect)
    });
    let leave = all.iter().filter(|hosted| !said(&hosted.name));
    cut.chain(leave.map(|hosted| Step::Unload(hosted.name.clone()))).collect()
}

/// The steps that the deployment asks for.
fn wanted_steps(
    present: Present<'_>,
    wanted: &Deployment,
    prune: bool,
) -> Result<Vec<Step>, Contradiction> {
    let mut steps = Vec::new();
    for request in ordered(&wanted.component)? {
        let name = request.instance();
        match present.components.get(&name) {
            None => steps.push(Step::Load(Box::new(request.clone()))),
            Some(hosted) => adapt(&hosted, request, present, &mut steps)?,
        }
    }
    let known = |instance: &str| {
        present.components.get(instance).is_some()
            || wanted.component.iter().any(|request| request.instance() == instance)
    };
    let check = |what: String, instance: &str, place: Spot| {
        if known(instance) {
            return Ok(());
        }
        let mut names: Vec<String> = wanted.component.iter().map(LoadRequest::instance).collect();
        names.extend(present.components.all().iter().map(|hosted| hosted.name.clone()));
        let help = suggest(instance, names.iter().map(String::as_str));
        Err(Contradiction::Unknown { what, typed: instance.to_owned(), help, place })
    };
    for connection in &wanted.connection {
        let place = Spot::connection(connection).key(["in"]);
        check(format!("in = \"{}\"", connection.inport), connection.reader(), place)?;
        let made = present.connections.present(&connection.inport);
        if anew(&steps, connection.reader()) || !made.is_some_and(|made| made.is(connection)) {
            steps.push(Step::Connect(connection.clone()));
        }
    }
    // Connections of a component that is reloaded are made again if the deployment does not mention
    // them.
    for hosted in present.components.all() {
        if prune || !anew(&steps, &hosted.name) {
            continue;
        }
        let said = |entry: &ConnectionEntry| {
            wanted.connection.iter().any(|one| one.inport == entry.inport)
        };
        steps.extend(entries(&hosted).into_iter().filter(|one| !said(one)).map(Step::Connect));
    }
    let (calls, starts) = (wanted.call.iter(), wanted.activity.iter());
    let calls = calls.map(|entry| (entry, Step::Call(entry.clone())));
    for (entry, step) in calls.chain(starts.map(|entry| (entry, Step::Start(entry.clone())))) {
        let section = if matches!(step, Step::Call(_)) { "call" } else { "activity" };
        let place = Spot::request(section, entry).key(["component"]);
        check(format!("the call of {}", entry.service), &entry.component, place)?;
        if anew(&steps, &entry.component) || !is_met(present.components, entry) {
            steps.push(step);
        }
    }
    Ok(steps)
}

/// The connections of a component, as entries of a deployment.
pub(super) fn entries(hosted: &Hosted) -> Vec<ConnectionEntry> {
    hosted.ties.connections().iter().map(Connection::entry).collect()
}

/// Whether the steps reload this component.
fn anew(steps: &[Step], name: &str) -> bool {
    steps
        .iter()
        .any(|step| matches!(step, Step::Reload { request, .. } if request.instance() == name))
}

/// The components in an order that respects their `after`.
fn ordered(all: &[LoadRequest]) -> Result<Vec<&LoadRequest>, Contradiction> {
    let mut left: Vec<&LoadRequest> = all.iter().collect();
    let mut names: Vec<String> = Vec::new();
    for request in all {
        let name = request.instance();
        // A component without a name in the request gets that of its description, which is not read
        // yet.
        if names.contains(&name) && request.name.is_some() {
            return Err(Contradiction::Twice(name));
        }
        names.push(name);
    }
    let mut order = Vec::with_capacity(all.len());
    while !left.is_empty() {
        let waits = |request: &&LoadRequest, name: &String| {
            request.after.contains(name) && request.instance() != *name
        };
        let pending: Vec<String> = left.iter().map(|request| request.instance()).collect();
        let free = left.iter().position(|request| {
            !request.after.contains(&request.instance())
                && !pending.iter().any(|name| waits(request, name))
        });
        let Some(free) = free else { return Err(Contradiction::Circle(pending[0].clone())) };
        let request = left.remove(free);
        if let Some(unknown) = request.after.iter().find(|after| !names.contains(after)) {
            let what = format!("after of {}", request.instance());
            let help = suggest(unknown, names.iter().map(String::as_str));
            let place = Spot::component(request).key(["after"]);
            return Err(Contradiction::Unknown { what, typed: unknown.clone(), help, place });
        }
        order.push(request);
    }
    Ok(order)
}

/// Whether a component runs from the library that a request names, however it names it.
fn is_library(hosted: &Hosted, request: &LoadRequest, path: &[PathBuf]) -> bool {
    let build = hosted.build();
    if [&build.request.library, &build.library].contains(&&request.library) {
        return true;
    }
    let found = locate(request, path).ok().map(|found| found.library);
    let found = found.and_then(|library| std::path::absolute(library).ok());
    found.is_some_and(|library| library == build.library)
}

/// Steps for a component that is running already.
fn adapt(
    hosted: &Hosted,
    request: &LoadRequest,
    present: Present<'_>,
    steps: &mut Vec<Step>,
) -> Result<(), Contradiction> {
    let name = hosted.name.clone();
    if !is_library(hosted, request, present.path) {
        let place = Spot::component(request).key(["library"]);
        return Err(Contradiction::Other { name, place });
    }
    let runs = hosted.build().request;
    let other = if runs.tasks != request.tasks {
        Some("other settings of tasks")
    } else if runs.qos != request.qos {
        Some("another quality of service of ports")
    } else if runs.on_failure != request.on_failure {
        Some("other things to do when it fails")
    } else if runs.supervision != request.supervision {
        Some("other rules of supervision")
    } else {
        None
    };
    if let Some(why) = other {
        let mut request = request.clone();
        request.name = Some(name);
        // Attributes that were set and that the deployment does not mention are set again.
        for (service, set) in hosted.standing.attributes() {
            let inputs = match request.attributes.get(&service) {
                None => Some(set),
                Some(wanted) => merged(hosted, &service, &set, wanted),
            };
            request.attributes.extend(inputs.map(|inputs| (service, inputs)));
        }
        steps.push(Step::Reload { request: Box::new(request), why });
        return Ok(());
    }
    let default = || BackendNames::one(present.backend);
    let to = request.backend.clone().unwrap_or_else(default);
    let bindings = &hosted.ties.bindings;
    let moves = bindings.component() != to;
    if moves {
        steps.push(Step::Move { component: name.clone(), port: None, to: to.clone() });
    }
    for port in &hosted.model().ports {
        let wanted = request.ports.get(&port.name).unwrap_or(&to);
        let present = if moves { to.clone() } else { bindings.port(&port.name) };
        if present != *wanted {
            let (component, port) = (name.clone(), Some(port.name.clone()));
            steps.push(Step::Move { component, port, to: wanted.clone() });
        }
    }
    let set = hosted.standing.attributes();
    for (service, inputs) in &request.attributes {
        if set
            .get(service)
            .is_none_or(|set| merged(hosted, service, set, inputs).as_ref() != Some(set))
        {
            let (component, service) = (name.clone(), service.clone());
            steps.push(Step::Set(CallEntry { component, service, inputs: inputs.clone() }));
        }
    }
    Ok(())
}

/// The inputs, completed with defaults.
fn full(hosted: &Hosted, service: &str, inputs: &Value) -> Option<Value> {
    let index = hosted.plan().service(service)?;
    hosted.filled(index, inputs).ok().map(|record| record.to_json())
}

/// The inputs that an attribute has if it is set to `set` and then to the partial `inputs`.
fn merged(hosted: &Hosted, service: &str, set: &Value, inputs: &Value) -> Option<Value> {
    let mut record = hosted.filled(hosted.plan().service(service)?, set).ok()?;
    record.merge_json(inputs).ok()?;
    Some(record.to_json())
}

/// Whether a deployment already called this service with these inputs since the component was
/// loaded, or such an activity is running.
fn is_met(components: &Components, entry: &CallEntry) -> bool {
    let Some(hosted) = components.get(&entry.component) else { return false };
    let Some(wanted) = full(&hosted, &entry.service, &entry.inputs) else { return false };
    let equal = |service: &str, inputs: &Value| {
        service == entry.service && full(&hosted, service, inputs).as_ref() == Some(&wanted)
    };
    let deployed = hosted.standing.all_deployed();
    let running = hosted.activities.all();
    deployed.iter().any(|(service, inputs)| equal(service, inputs))
        || running.iter().any(|activity| {
            let inputs = hosted.standing.inputs(activity.number);
            inputs.is_some_and(|inputs| equal(&activity.service, &inputs))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(name: &str, after: &[&str]) -> LoadRequest {
        LoadRequest {
            name: Some(name.to_owned()),
            after: after.iter().map(|&name| name.to_owned()).collect(),
            ..LoadRequest::default()
        }
    }

    #[test]
    fn components_come_after_those_they_name() {
        let all = [request("a", &["c"]), request("b", &[]), request("c", &["b"])];
        let order = ordered(&all).unwrap();
        let names: Vec<String> = order.iter().map(|request| request.instance()).collect();
        assert_eq!(names, ["b", "c", "a"]);
    }

    #[test]
    fn circles_unknown_and_double_names_are_refused() {
        let circle = ordered(&[request("a", &["b"]), request("b", &["a"])]).unwrap_err();
        assert!(matches!(circle, Contradiction::Circle(_)), "{circle}");
        assert!(ordered(&[request("a", &["a"])]).is_err());
        let unknown = ordered(&[request("arm", &[]), request("b", &["amr"])]).unwrap_err();
        assert!(unknown.to_string().contains("`arm`"), "{unknown}");
        assert!(matches!(
            ordered(&[request("a", &[]), request("a", &[])]),
            Err(Contradiction::Twice(_))
        ));
    }
}
