//! Connecting remotes to services: of this daemon directly, of others through a middleware.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Instant;

use genom_middleware::describe::types_of_service;
use genom_middleware::{Address, EndpointKind, Middleware, OpenError, ServiceType};
use genom_nearest::suggest;
use genom_runtime::HeldUp;
use genom_runtime::body::RemoteCall;
use genom_types::DataType;

use super::calls::{DirectCall, FarCall};
use super::connect::{LOOK_AGAIN, Patience};
use super::serve::kind_of;
use crate::bus::Change;
use crate::daemon::Daemon;
use crate::hosting::Hosted;
use crate::wires::RemoteConnection;
use genom_configuration::place::{Place, PlaceError};
use genom_registry::BackendError;

/// A remote to connect.
#[derive(Clone, Debug)]
pub struct RemoteRequest {
    /// `component/remote`, of this daemon.
    pub remote: String,
    /// `component/service`, of this daemon or of another one; a middleware may stand before it.
    pub service: String,
    /// Through this middleware, also within the daemon.
    pub backend: Option<String>,
    /// Connect to a service that is not there yet.
    pub wait: bool,
    /// How long to look for it on a network.
    pub patience: Patience,
}

/// A remote could not be connected; what was there before still is.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum RemoteError {
    /// No such remote.
    #[error("no_such_remote: there is no remote `{typed}`; {help}")]
    NoSuchRemote { typed: String, help: String },
    /// No such service.
    #[error("no_such_service: there is no service `{typed}`{place}; {help}")]
    NoSuchService {
        typed: String,
        place: String,
        help: String,
        /// It may come later.
        absent: bool,
    },
    /// The service takes or gives something else.
    #[error("{remote} calls {ours}, {service} is {theirs}: make the two .gen interfaces equal")]
    Differs { remote: String, ours: String, service: String, theirs: String },
    /// No such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The middleware refused.
    #[error(transparent)]
    Failed(Box<OpenError>),
    /// A codel of the caller does not return.
    #[error(transparent)]
    HeldUp(#[from] HeldUp),
}

/// Connects a remote, in place of the service it had.
pub fn connect(
    daemon: &Arc<Daemon>,
    request: &RemoteRequest,
) -> Result<RemoteConnection, RemoteError> {
    let (caller, remote) = find_remote(daemon, &request.remote)?;
    let refuse = |help: &str| RemoteError::NoSuchService {
        typed: request.service.clone(),
        place: String::new(),
        help: help.to_owned(),
        absent: false,
    };
    let place = Place::parse(&request.service).map_err(|error| match error {
        PlaceError::Backend(error) => RemoteError::Backend(error),
        PlaceError::Form(_) => refuse("write COMPONENT/SERVICE, or BACKEND:COMPONENT/SERVICE"),
    })?;
    let asked = match (&place.backend, &request.backend) {
        (Some(one), Some(other)) if one != other => {
            return Err(refuse(&format!("it is on {one}, and {other} is asked for: name one")));
        }
        (one, other) => one.clone().or(other.clone()),
    };
    let fixed = asked.is_some();
    let own = daemon.components.get(&place.address.instance);
    let (call, backend): (Box<dyn RemoteCall>, _) = match (asked, own) {
        (None, Some(provider)) => {
            (Box::new(near(daemon, &caller, remote, &provider, request, &place.address)?), None)
        }
        (asked, _) => {
            let far = far(daemon, &caller, remote, asked, request, &place.address)?;
            let backend = far.backend().to_owned();
            (Box::new(far), Some(backend))
        }
    };
    caller.bind_remote(remote, Some(call))?;
    let name = &caller.model().remotes[remote].name;
    let remote_name = caller.address(name, None);
    let connection =
        RemoteConnection { remote: remote_name, service: place.address, backend, fixed };
    caller.wires.remote_connected(remote, connection.clone());
    daemon.bus.tell(&Change::RemoteConnected {
        remote: connection.remote.to_string(),
        service: connection.service.to_string(),
    });
    Ok(connection)
}

/// A call of a component of this daemon: everything about it is known.
fn near(
    daemon: &Arc<Daemon>,
    caller: &Hosted,
    remote: usize,
    provider: &Hosted,
    request: &RemoteRequest,
    at: &Address,
) -> Result<DirectCall, RemoteError> {
    let services = &provider.model().services;
    let Some(theirs) = services.iter().find(|service| service.name == at.name) else {
        return Err(RemoteError::NoSuchService {
            typed: request.service.clone(),
            place: " in this daemon".to_owned(),
            help: suggest(&at.name, services.iter().map(|one| one.name.as_str())),
            absent: false,
        });
    };
    let ours = &caller.model().remotes[remote];
    // genom3.md 4.9: digests of the two are compared when they are connected.
    if ours.digest != theirs.call_digest {
        return Err(RemoteError::Differs {
            remote: request.remote.clone(),
            ours: format!("{} of interface {} ({})", ours.name, ours.interface, ours.digest),
            service: request.service.clone(),
            theirs: format!("{} ({})", theirs.name, theirs.call_digest),
        });
    }
    Ok(DirectCall::new(daemon, provider, theirs, &caller.model().version))
}

/// A call through a middleware: the one asked for, else one the caller is on, the first where
/// the service shows.
fn far(
    daemon: &Daemon,
    caller: &Hosted,
    remote: usize,
    asked: Option<String>,
    request: &RemoteRequest,
    at: &Address,
) -> Result<FarCall, RemoteError> {
    let middlewares = reaching(daemon, caller, asked.as_deref(), request, at)?;
    let middleware = choose(daemon, &middlewares, request, at)?;
    let (model, types) = (&caller.model().remotes[remote], &caller.specification().types);
    let lay_out = |ty| {
        DataType::new(types, ty).map_err(|error| {
            let (backend, why) = (middleware.name().to_owned(), error.to_string());
            RemoteError::Failed(Box::new(OpenError::Failed { backend, address: at.clone(), why }))
        })
    };
    // genom3.md 4.9: parameters and exceptions must agree here as well.
    let ty = ServiceType::new(kind_of(model.kind), lay_out(model.input)?, lay_out(model.output)?)
        .described(&model.digest);
    let ours = types_of_service(&ty);
    FarCall::open(&middleware, at, ty, &caller.model().version).map_err(|error| match error {
        OpenError::TypeMismatch { theirs, .. } => RemoteError::Differs {
            remote: request.remote.clone(),
            ours: format!("{} of interface {}: {ours}", model.name, model.interface),
            service: request.service.clone(),
            theirs,
        },
        error => RemoteError::Failed(Box::new(error)),
    })
}

/// The middlewares through which the service may be found.
fn reaching(
    daemon: &Daemon,
    caller: &Hosted,
    asked: Option<&str>,
    request: &RemoteRequest,
    at: &Address,
) -> Result<Vec<Arc<dyn Middleware>>, RemoteError> {
    if let Some(asked) = asked {
        return Ok(vec![daemon.backends.get(asked)?]);
    }
    let bindings = caller.wires.bindings.component();
    let mut all = Vec::new();
    for name in bindings.names() {
        let middleware = daemon.backends.get(name)?;
        let can = middleware.capabilities();
        if can.services && can.cross_process {
            all.push(middleware);
        }
    }
    if all.is_empty() {
        let components = daemon.components.all();
        let names = components.iter().map(|hosted| hosted.name.as_str());
        return Err(RemoteError::NoSuchService {
            typed: request.service.clone(),
            place: format!(": no such component in this daemon, and {bindings} calls no other"),
            help: suggest(&at.instance, names),
            absent: false,
        });
    }
    Ok(all)
}

/// The first that shows the service; on a network it is looked for as long as that may take.
fn choose(
    daemon: &Daemon,
    all: &[Arc<dyn Middleware>],
    request: &RemoteRequest,
    at: &Address,
) -> Result<Arc<dyn Middleware>, RemoteError> {
    let wanted = at.to_string();
    let patience = if request.wait { Patience::None } else { request.patience };
    let ends = all.iter().map(|middleware| patience.end(daemon, middleware.as_ref()));
    let end = ends.max().unwrap_or_else(Instant::now);
    loop {
        let mut visible = BTreeSet::new();
        for middleware in all {
            let services = services(middleware.as_ref(), at)?;
            if services.contains(&middleware.spelled(at)) {
                return Ok(Arc::clone(middleware));
            }
            visible.extend(services);
        }
        if Instant::now() < end {
            std::thread::park_timeout(LOOK_AGAIN);
            continue;
        }
        return match all.first() {
            Some(first) if request.wait => Ok(Arc::clone(first)),
            _ => {
                let names: Vec<_> = all.iter().map(|middleware| middleware.name()).collect();
                Err(RemoteError::NoSuchService {
                    typed: request.service.clone(),
                    place: format!(" on {}", names.join(", ")),
                    help: format!(
                        "{}; one that comes later is waited for with --wait",
                        suggest(&wanted, visible.iter().map(String::as_str))
                    ),
                    absent: true,
                })
            }
        };
    }
}

/// Whether somebody announces this service on a middleware.
pub fn serves(middleware: &dyn Middleware, service: &Address) -> bool {
    services(middleware, service).is_ok_and(|all| all.contains(&middleware.spelled(service)))
}

/// Addresses of the services visible now.
fn services(middleware: &dyn Middleware, at: &Address) -> Result<BTreeSet<String>, RemoteError> {
    let endpoints = middleware.discover().map_err(|error| {
        let (backend, address, why) = (error.backend, at.clone(), error.why);
        RemoteError::Failed(Box::new(OpenError::Failed { backend, address, why }))
    })?;
    let services = endpoints.into_iter().filter(|found| found.kind == EndpointKind::Service);
    Ok(services.map(|found| found.address).collect())
}

/// Takes the service behind a remote away; whether there was one.
pub fn disconnect(daemon: &Daemon, caller: &Hosted, remote: usize) -> Result<bool, HeldUp> {
    let Some(had) = caller.wires.remote_disconnected(remote) else { return Ok(false) };
    if let Err(held_up) = caller.bind_remote(remote, None) {
        caller.wires.remote_connected(remote, had);
        return Err(held_up);
    }
    let remote = caller.address(&caller.model().remotes[remote].name, None);
    daemon.bus.tell(&Change::RemoteDisconnected { remote: remote.to_string() });
    Ok(true)
}

/// The remote that an address names, if it names one.
pub fn named(daemon: &Daemon, address: &str) -> Option<(Arc<Hosted>, usize)> {
    find_remote(daemon, address).ok()
}

fn find_remote(daemon: &Daemon, typed: &str) -> Result<(Arc<Hosted>, usize), RemoteError> {
    let refuse = |help| RemoteError::NoSuchRemote { typed: typed.to_owned(), help };
    let write = || refuse("write COMPONENT/REMOTE".to_owned());
    let address: genom_protocol::Address = typed.parse().map_err(|_| write())?;
    let name = address.name();
    let caller = daemon.components.get(&address.component).ok_or_else(|| {
        let all = daemon.components.all();
        refuse(suggest(&address.component, all.iter().map(|hosted| hosted.name.as_str())))
    })?;
    let remotes = &caller.model().remotes;
    match remotes.iter().position(|remote| remote.name == name) {
        Some(index) => Ok((caller, index)),
        None => Err(refuse(suggest(&name, remotes.iter().map(|remote| remote.name.as_str())))),
    }
}
