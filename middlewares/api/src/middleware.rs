//! A middleware as a whole: its name, its capabilities, and the optional concerns it implements.
//!
//! Every middleware opens ports. [`Services`], [`Discovery`] and [`Relay`] are separate traits: a
//! backend implements those it can, and returns itself from the method of that name. Callers use
//! the methods of `dyn Middleware`, which answer with one uniform error where a concern is missing.

use std::borrow::Cow;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::{
    Address, Client, Diagnosis, DiscoverError, Discovery, Endpoint, LogEntry, NoForeignName,
    Obstacle, OpenError, Ports, Relay, Served, ServiceHandler, ServiceType, Services, Stranger,
};

/// An open middleware. A daemon has one value of each, shared by all its components.
pub trait Middleware: Ports + Send + Sync {
    /// Name in configurations: `local`, `shm`, `zenoh`, `ros2`.
    fn name(&self) -> &'static str;

    /// What this middleware can do. A component that needs more is refused when it is loaded.
    fn capabilities(&self) -> Capabilities;

    /// The services of this middleware; `None` if [`Capabilities::services`] is false.
    fn services(&self) -> Option<&dyn Services> {
        None
    }

    /// Discovery on this middleware; `None` if its peers do not announce themselves.
    fn discovery(&self) -> Option<&dyn Discovery> {
        None
    }

    /// Requests to other daemons through this middleware; `None` if it has no way for them.
    fn relay(&self) -> Option<&dyn Relay> {
        None
    }

    /// Settings that a foreign program needs to find the ports of this middleware, as names and
    /// values (for example a domain number). Empty if none are needed.
    fn meeting_point(&self) -> Vec<(Cow<'static, str>, String)> {
        Vec::new()
    }

    /// From now on, exposes `ours` as `foreign`: a type or a service, by its full name such as
    /// `::demo::pose`, as the middleware's own type; an instance (`demo`), or a port or a service of
    /// one (`demo/position`), under another name. A backend without types or names of its own
    /// ignores this.
    ///
    /// # Errors
    /// `foreign` is not a valid name; the text says what would be one.
    fn masquerade(&self, ours: &str, foreign: &str) -> Result<(), NoForeignName> {
        let _ = (ours, foreign);
        Ok(())
    }

    /// Undoes [`masquerade`](Middleware::masquerade) for whatever is opened from now on.
    fn unmask(&self, ours: &str) {
        let _ = ours;
    }

    /// From now on, the time of components is that of a simulator, which tells it on this middleware.
    /// Called before anything is opened. A backend whose peers do not ask for that ignores it.
    fn simulated_time(&self) {}

    /// Whether tools of this middleware show what components log and how their tasks fare.
    fn takes_reports(&self) -> bool {
        false
    }

    /// Shows an entry of a component's log. Does not block; without an effect if no port or service
    /// of the component is open here.
    fn log(&self, entry: &LogEntry) {
        let _ = entry;
    }

    /// Shows how components fare. Does not block; tasks of components that have no port or service
    /// open here are left out.
    fn diagnose(&self, parts: &[Diagnosis]) {
        let _ = parts;
    }

    /// What keeps this process from others on this middleware, as a whole. May take some seconds.
    fn trouble(&self) -> Vec<Obstacle> {
        Vec::new()
    }

    /// Harmful input from peers that was refused, counted by reason.
    fn refused(&self) -> Vec<Refused> {
        Vec::new()
    }
}

/// What a middleware can do. The daemon refuses components that need more when it loads them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Capabilities {
    /// Carries types that hold unbounded strings or sequences.
    pub variable_size: bool,
    /// Readers access the writer's memory; the middleware makes no copy.
    pub zero_copy: bool,
    /// Reaches other processes on this machine.
    pub cross_process: bool,
    /// Reaches other machines.
    pub cross_host: bool,
    /// Serves and calls services.
    pub services: bool,
    /// Peers that are not genomd can call the services.
    pub native_services: bool,
}

impl Capabilities {
    /// Those of a middleware that copies samples to any machine.
    pub const NETWORK: Self = Self {
        variable_size: true,
        zero_copy: false,
        cross_process: true,
        cross_host: true,
        services: true,
        native_services: true,
    };
}

/// Input from peers that was refused for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Refused {
    /// The reason, worded as in the log.
    pub why: Cow<'static, str>,
    /// How often so far.
    pub count: u64,
    /// Sender of the last one, if known.
    pub peer: Option<std::net::IpAddr>,
}

/// The optional concerns, for callers that do not check whether a middleware has them: if it has
/// not, they return an error that says so.
impl dyn Middleware + '_ {
    /// The same as [`Services::serve`].
    ///
    /// # Errors
    /// The same, or the middleware has no services.
    pub fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        match self.services() {
            Some(services) => services.serve(at, service, handler),
            None => Err(self.without_services(service)),
        }
    }

    /// The same as [`Services::client`].
    ///
    /// # Errors
    /// The same, or the middleware has no services.
    pub fn client(
        &self,
        at: &Address,
        service: &ServiceType,
    ) -> Result<Box<dyn Client>, OpenError> {
        match self.services() {
            Some(services) => services.client(at, service),
            None => Err(self.without_services(service)),
        }
    }

    fn without_services(&self, service: &ServiceType) -> OpenError {
        OpenError::Unsupported {
            backend: self.name().to_owned(),
            ty: service.input.name().to_owned(),
            why: "it has no services; bind the service to another backend".to_owned(),
        }
    }

    /// The same as [`Discovery::discover`].
    ///
    /// # Errors
    /// The same, or the middleware has no discovery.
    pub fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        self.known()?.discover()
    }

    /// The same as [`Discovery::ends_at`].
    ///
    /// # Errors
    /// The same, or the middleware has no discovery.
    pub fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        self.known()?.ends_at(at)
    }

    fn known(&self) -> Result<&dyn Discovery, DiscoverError> {
        self.discovery().ok_or_else(|| DiscoverError {
            backend: self.name().to_owned(),
            why: "it does not know who is there; connect to the address as you know it".to_owned(),
        })
    }

    /// The same as [`Discovery::spelled`]; the plain address if the middleware has no discovery.
    #[must_use]
    pub fn spelled(&self, at: &Address) -> String {
        self.discovery().map_or_else(|| at.to_string(), |discovery| discovery.spelled(at))
    }

    /// The same as [`Discovery::strangers`]; empty if the middleware has no discovery.
    #[must_use]
    pub fn strangers(&self) -> Vec<Stranger> {
        self.discovery().map(Discovery::strangers).unwrap_or_default()
    }

    /// The same as [`Discovery::obstacles`]; empty if the middleware has no discovery.
    #[must_use]
    pub fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        self.discovery().map(|discovery| discovery.obstacles(at)).unwrap_or_default()
    }
}
