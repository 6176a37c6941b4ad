//! Checks what is to be done when components fail (`on_failure`) or break a rule, and these rules
//! (`supervision`), against the components that a deployment loads, before any of them runs: nobody
//! finds out at the moment of a failure.

use genom_configuration::{Act, Deed, Deployment, LoadRequest, Reaction, Spot, SupervisionEntry};
use genom_description::model::{Component as Model, ServiceKind};
use genom_nearest::suggest;
use genom_rules::{NoSuchRule, rules};

use crate::settings::Settings;
use genom_finder::Reading;
use genom_finder::locate;

/// Why a reaction could not be done.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum IdleReaction {
    /// Its component is not there.
    #[error("{reaction}: no component `{typed}` runs or is deployed here; {help}")]
    NoComponent { reaction: String, typed: String, help: String },
    /// Its component has no such service or event.
    #[error("{reaction}: {component} has no {what} `{typed}`; {help}")]
    NoSuch { reaction: String, component: String, what: &'static str, typed: String, help: String },
    /// A service that is none to start.
    #[error("{reaction}: {typed} is no activity: say `call`")]
    NoActivity { reaction: String, typed: String },
    /// Its component fails at the same time.
    #[error(
        "{reaction}: {component} runs in cell {cell}, too, and ends with it: give it another cell, \
         or none"
    )]
    SameCell { reaction: String, component: String, cell: String },
    /// A rule does not fit its component.
    #[error(transparent)]
    Rule(#[from] NoSuchRule),
}

/// Checks all reactions of a deployment. `runs` knows components that run and that the deployment
/// does not load.
///
/// # Errors
/// The first that could not be done, with its place.
pub fn check_reactions(
    settings: &Settings,
    wanted: &Deployment,
    runs: impl Fn(&str) -> bool,
) -> Result<(), (Spot, Box<IdleReaction>)> {
    for request in &wanted.component {
        for reaction in &request.on_failure {
            check(settings, wanted, reaction, request.cell.as_deref(), &runs)
                .map_err(|why| (Spot::component(request).key(["on_failure"]), Box::new(why)))?;
        }
        let place = || Spot::component(request).key(["supervision"]);
        for reaction in request.supervision.iter().flat_map(SupervisionEntry::others) {
            check(settings, wanted, reaction, None, &runs)
                .map_err(|why| (place(), Box::new(why)))?;
        }
        if !request.supervision.is_empty() {
            check_rules(settings, request).map_err(|why| {
                let place = Spot::component(request);
                let place = place.key(["supervision".to_owned(), why.at().to_string()]);
                (place, Box::new(IdleReaction::Rule(why)))
            })?;
        }
    }
    Ok(())
}

/// Whether the rules of a component fit it.
fn check_rules(settings: &Settings, request: &LoadRequest) -> Result<(), NoSuchRule> {
    // What cannot be read is refused with its reason when it is loaded.
    let Ok(located) = locate(request, &settings.path) else { return Ok(()) };
    let Ok(reading) = Reading::new(&located.description, &settings.include) else { return Ok(()) };
    rules(request, reading.model()).map(drop)
}

/// With `cell`, the reaction cannot be done in this one: it has ended.
fn check(
    settings: &Settings,
    wanted: &Deployment,
    reaction: &Reaction,
    cell: Option<&str>,
    runs: impl Fn(&str) -> bool,
) -> Result<(), IdleReaction> {
    // The form of one that was read is right.
    let Ok(deed) = reaction.deed() else { return Ok(()) };
    let of_that_name = |one: &&LoadRequest| one.instance() == deed.component;
    let Some(target) = wanted.component.iter().find(of_that_name) else {
        if runs(&deed.component) {
            return Ok(());
        }
        let names: Vec<String> = wanted.component.iter().map(LoadRequest::instance).collect();
        let help = suggest(&deed.component, names.iter().map(String::as_str));
        let (reaction, typed) = (reaction.to_string(), deed.component);
        return Err(IdleReaction::NoComponent { reaction, typed, help });
    };
    if let Some(cell) = cell.filter(|_| target.cell.as_deref() == cell) {
        let (reaction, component, cell) = (reaction.to_string(), deed.component, cell.to_owned());
        return Err(IdleReaction::SameCell { reaction, component, cell });
    }
    // What cannot be read is refused with its reason when it is loaded.
    let Ok(located) = locate(target, &settings.path) else { return Ok(()) };
    let Ok(reading) = Reading::new(&located.description, &settings.include) else { return Ok(()) };
    has(reading.model(), &deed, reaction)
}

/// Whether a component has the service or event.
fn has(model: &Model, deed: &Deed, reaction: &Reaction) -> Result<(), IdleReaction> {
    let Deed { act, component, name } = deed.clone();
    let reaction = reaction.to_string();
    let refuse = |what, names: Vec<&str>| {
        let help = suggest(&name, names);
        let (reaction, component, typed) = (reaction.clone(), component.clone(), name.clone());
        Err(IdleReaction::NoSuch { reaction, component, what, typed, help })
    };
    if act == Act::Fire {
        return match model.sinks.iter().any(|sink| sink.name == name) {
            true => Ok(()),
            false => refuse("event", model.sinks.iter().map(|sink| sink.name.as_str()).collect()),
        };
    }
    match model.services.iter().find(|service| service.name == name) {
        None => refuse("service", model.services.iter().map(|one| one.name.as_str()).collect()),
        Some(service) if act == Act::Start && service.kind != ServiceKind::Activity => {
            Err(IdleReaction::NoActivity { typed: format!("{component}/{name}"), reaction })
        }
        Some(_) => Ok(()),
    }
}
