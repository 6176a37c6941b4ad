//! Loads a component: finds, reads, checks, allocates, binds and starts it. If a step fails,
//! everything is undone.

pub(crate) mod built;
mod error;
mod reactions;
mod source;
mod standard;
mod start;
mod warnings;

use std::sync::Arc;

use genom_configuration::{BackendNames, CallEntry, LoadRequest};
use genom_description::model::{Component as Model, PortDirection, ServiceKind};
use genom_finder::{Located, Reading, defined_in, locate};
use genom_host::{Component, Contents, Digest, Library, OpenError};
use genom_nearest::suggest;
use genom_protocol::{Renamed, Sources};

use self::standard::unload_killed;
use self::warnings::tell_warnings;
use crate::components::request::{self, RequestError};
use crate::components::{Build, Hosted, sources};
use crate::settings::Settings;
use crate::supervisor::Supervisor;
pub use built::text as date_in_utc;
pub use error::LoadError;
use genom_bus::Change;
pub use genom_finder::names_script;
pub use genom_rules::NoSuchRule;
pub use reactions::{IdleReaction, check_reactions};
pub(crate) use source::{Source, texts_beside};

impl Supervisor {
    /// Loads a component, starts it and sets its attributes. Blocks for file access and start
    /// codels.
    ///
    /// # Errors
    /// A step failed; everything done for the component was undone.
    pub fn load(self: &Arc<Self>, request: &LoadRequest) -> Result<Arc<Hosted>, LoadError> {
        self.load_from(request, Source::find(self, request)?)
    }

    /// Loads a component from what was found, and perhaps opened, before.
    pub(crate) fn load_from(
        self: &Arc<Self>,
        request: &LoadRequest,
        source: Source,
    ) -> Result<Arc<Hosted>, LoadError> {
        if self.stopping() {
            return Err(LoadError::Stopping);
        }
        let hosted = bring_up(self, request, source)?;
        if let Err((service, RequestError { key, why })) = set_attributes(&hosted, request) {
            let name = hosted.name.clone();
            drop(hosted);
            self.components.remove(
                std::slice::from_ref(&name),
                self.settings.stop_timeout,
                &|_, stopped| {
                    if let Err(error) = stopped {
                        tracing::error!("{error}");
                    }
                },
            );
            // In the file the inputs stand directly under the service's name.
            let members = key.into_iter().filter(|key| key != "inputs");
            let mut key = vec!["attributes".to_owned(), service];
            key.extend(members);
            return Err(LoadError::Attribute { name, key, why });
        }
        self.runs(&hosted);
        if request.instead.is_some() && request.resume.is_some() {
            let component = hosted.name.clone();
            tracing::warn!(
                instance = component,
                "the process ended soon after a reload: it runs what it ran before"
            );
            self.bus.tell(&Change::ComponentRolledBack { component });
        }
        for note in &hosted.notes {
            tracing::warn!(instance = hosted.name, "{note}");
        }
        Ok(hosted)
    }
}

/// Sets the attributes; on failure returns the one that was refused.
fn set_attributes(hosted: &Hosted, request: &LoadRequest) -> Result<(), (String, RequestError)> {
    for (service, inputs) in &request.attributes {
        // What the state that was put back has of it already.
        let resumed = request.resume.as_deref().map(|resumption| &resumption.state.attributes);
        if resumed.and_then(|known| known.get(service)) == Some(inputs) {
            hosted.standing.attribute(service, inputs.clone());
            continue;
        }
        let (component, service) = (hosted.name.clone(), service.clone());
        let entry = CallEntry { component, service, inputs: inputs.clone() };
        request::send_to(hosted, &entry).map_err(|error| (entry.service, error))?;
    }
    Ok(())
}

fn bring_up(
    supervisor: &Arc<Supervisor>,
    request: &LoadRequest,
    source: Source,
) -> Result<Arc<Hosted>, LoadError> {
    let named = request.backend.iter().chain(request.ports.values());
    for backend in named.flat_map(BackendNames::names) {
        supervisor.backends.get(backend)?;
    }
    let Source { located, reading, opened } = source;
    let model = reading.model();
    let name = request.name.clone().unwrap_or_else(|| model.name.clone());
    if !is_name(&name) {
        return Err(LoadError::Name(name));
    }
    check_names(request, model, &name)?;
    let Some(reservation) = supervisor.components.reserve(&name) else {
        return Err(LoadError::Taken(name));
    };
    let source = Source { located, reading, opened };
    let hosted = begin(supervisor, request, name, source, None)?;
    reservation.keep(Arc::clone(&hosted));
    if hosted.killed.is_up() {
        unload_killed(&Arc::downgrade(supervisor), &hosted.name);
    }
    Ok(hosted)
}

/// Starts what was found, under a name that is free, or beside the component that has it.
pub(crate) fn begin(
    supervisor: &Arc<Supervisor>,
    request: &LoadRequest,
    name: String,
    source: Source,
    before: Option<&Arc<Hosted>>,
) -> Result<Arc<Hosted>, LoadError> {
    let Source { mut located, reading, opened } = source;
    // Dropped when a step fails, otherwise kept as long as the component.
    let mut masquerades = Vec::new();
    for one in &reading.plan.specification().masquerades {
        let name = one.name.to_string();
        masquerades.extend(supervisor.backends.masquerade(&one.template, &name, &one.data)?);
    }
    masquerades.extend(supervisor.backends.rename(genom_protocol::renamed(&name, &request.remap))?);
    let opened = match opened {
        Some(opened) => opened,
        None => open(&mut located, &reading, &supervisor.settings)?,
    };
    let (component, digest) = opened;
    component.name_it(&name);
    let plan = Arc::clone(&reading.plan);
    // Absolute, because a dump may be read in another directory.
    let library = std::path::absolute(&located.library).unwrap_or(located.library);
    let (request, description) = (request.clone(), located.description);
    let build = Build { request, library, digest, description, reading };
    let hosted = start::start(supervisor, name, build, plan, component, before)?;
    hosted.ties.wear(masquerades);
    Ok(hosted)
}

/// Finds and reads the description of a component, and tells what it is made of. Its library is not
/// opened.
pub fn look(settings: &Settings, request: &LoadRequest) -> Result<Sources, LoadError> {
    let located = locate(request, &settings.path)?;
    let reading = Reading::new(&located.description, &settings.include)?;
    Ok(sources(&reading, request, settings))
}

/// Performs the checks of [`Supervisor::load`] without starting anything, and reports the result.
pub fn fit(settings: &Settings, request: &LoadRequest) -> Result<String, LoadError> {
    let mut located = locate(request, &settings.path)?;
    let reading = Reading::new(&located.description, &settings.include)?;
    tell_warnings(&located, &reading);
    open(&mut located, &reading, settings)?;
    let model = reading.model();
    Ok(format!(
        "{} fits {}: component {}, digest {}",
        located.library.display(),
        located.description.path().display(),
        model.name,
        model.digest
    ))
}

/// Opens the library and compares it with the description, unless that was done before.
pub(crate) fn open(
    located: &mut Located,
    reading: &Reading,
    settings: &Settings,
) -> Result<(Component, Digest), LoadError> {
    let contents = match located.contents.take() {
        Some(contents) => contents,
        None => Contents::read(&located.library)?,
    };
    let digest = contents.digest();
    let place = |span| reading.place(span);
    if contents.is_script() {
        let within = settings.start_timeout;
        return Ok((Component::load_script(contents, &reading.plan, within, &place)?, digest));
    }
    let library = Library::of(contents).map_err(|error| explain(error, reading))?;
    if reading.fits(&digest) {
        return Ok((Component::load_again(library, &reading.plan, &place)?, digest));
    }
    tracing::debug!("{}: compared with its description", located.library.display());
    let component = Component::load(library, &reading.plan, &place)?;
    reading.found_to_fit(digest);
    Ok((component, digest))
}

/// Explains an undefined symbol that one of the component's own sources defines.
fn explain(error: OpenError, reading: &Reading) -> LoadError {
    let OpenError::UndefinedSymbol { path, symbol } = &error else { return error.into() };
    match defined_in(symbol, path, reading.path()) {
        None => error.into(),
        Some(file) => LoadError::LeftOut { path: path.clone(), symbol: symbol.clone(), file },
    }
}

/// Fails if the request mentions a port, task or service that the component does not have.
pub(crate) fn check_names(
    request: &LoadRequest,
    model: &Model,
    instance: &str,
) -> Result<(), LoadError> {
    let check = |what, typed: &str, known: Vec<&str>| {
        if known.contains(&typed) {
            return Ok(());
        }
        let (name, typed) = (instance.to_owned(), typed.to_owned());
        let help = suggest(&typed, known);
        Err(LoadError::NoSuch { name, what, typed, help })
    };
    for port in request.ports.keys() {
        check("port", port, model.ports.iter().map(|port| port.name.as_str()).collect())?;
    }
    for (port, qos) in &request.qos.ports {
        let known = model.ports.iter().find(|known| known.name == *port);
        let refused = |why: &str| LoadError::Qos {
            name: instance.to_owned(),
            port: port.clone(),
            why: why.to_owned(),
        };
        match known {
            None => {
                let ports = model.ports.iter().map(|port| port.name.as_str());
                let help = suggest(port, ports);
                return Err(refused(&format!("it has no such port; {help}")));
            }
            Some(known) if known.direction == PortDirection::In && qos.depth.is_some() => {
                return Err(refused(
                    "`depth` is for out ports: what waits to be read is up to the connection's \
                     policy, for instance ring:5",
                ));
            }
            Some(_) => {}
        }
    }
    for rule in &request.remap {
        let Renamed::Name(typed) = &rule.what else { continue };
        let shown = typed.split('/').next().unwrap_or_default();
        let port = model.ports.iter().find(|port| port.name == shown);
        if port.is_some_and(|port| port.direction == PortDirection::In) {
            let (name, to) = (instance.to_owned(), rule.to.clone());
            return Err(LoadError::RemapsInPort { name, port: typed.clone(), to });
        }
        let known = model.ports.iter().filter(|port| port.direction == PortDirection::Out);
        let known = known.map(|port| port.name.as_str());
        let services = model.services.iter().map(|one| one.name.as_str());
        check("out port or service", shown, known.chain(services).collect())?;
    }
    for task in request.tasks.keys() {
        check("task", task, model.tasks.iter().map(|task| task.name.as_str()).collect())?;
    }
    genom_rules::rules(request, model).map_err(|why| LoadError::Supervision {
        name: instance.to_owned(),
        source: Box::new(why),
    })?;
    for attribute in request.attributes.keys() {
        let attributes = model.services.iter().filter(|one| one.kind == ServiceKind::Attribute);
        check("attribute", attribute, attributes.map(|one| one.name.as_str()).collect())?;
    }
    Ok(())
}

/// Instance names are used in addresses, file names and URLs.
fn is_name(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_alphabetic() || first == '_')
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= 64
}
