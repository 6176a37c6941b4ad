//! A middleware as a whole: what it is called, what it can do, and what it leaves out.
//!
//! Every middleware opens ports. Services, discovery and the way to other daemons are concerns of
//! their own: a backend implements [`Services`], [`Discovery`] or [`Relay`] where it can, and says
//! so here. Callers ask the middleware and are told, in one and the same sentence, what it cannot.

use std::sync::Arc;

use crate::{
    Address, Client, DiscoverError, Discovery, Endpoint, NoForeignName, Obstacle, OpenError, Ports,
    Relay, Served, ServiceHandler, ServiceType, Services, Stranger,
};

/// A middleware, open and ready. One value serves a whole daemon.
pub trait Middleware: Ports + Send + Sync {
    /// As configurations call it: `local`, `shm`, `zenoh`, `ros2`.
    fn name(&self) -> &'static str;

    /// What the daemon may ask of it; what is missing is refused at load.
    fn capabilities(&self) -> Capabilities;

    /// Serves and calls services; none if [`Capabilities::services`] is false.
    fn services(&self) -> Option<&dyn Services> {
        None
    }

    /// Lists ports and services on the middleware; none if its peers do not announce themselves.
    fn discovery(&self) -> Option<&dyn Discovery> {
        None
    }

    /// Passes requests to other daemons on this middleware; none if it has no way for that.
    fn relay(&self) -> Option<&dyn Relay> {
        None
    }

    /// What a program of another make must be told to meet the ports of this middleware, by name:
    /// nothing, when all on the machine or the network meet.
    fn meeting_point(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }

    /// Shows a type or service (`::demo::pose`, by its full name) as one of the middleware's own,
    /// from now on. A backend without such types has nothing to do.
    ///
    /// # Errors
    /// The foreign name is none; the error says what would be.
    fn masquerade(&self, ours: &str, foreign: &str) -> Result<(), NoForeignName> {
        let _ = (ours, foreign);
        Ok(())
    }

    /// Shows a type or service under its own name again, wherever it is opened from now on.
    fn unmask(&self, ours: &str) {
        let _ = ours;
    }

    /// What peers sent that would have harmed, and was refused.
    fn refused(&self) -> Vec<Refused> {
        Vec::new()
    }
}

/// What a middleware can do; the daemon refuses at load what it cannot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Capabilities {
    /// Carries types that hold unbounded strings or sequences.
    pub variable_size: bool,
    /// Readers see the writer's memory without a copy by the middleware.
    pub zero_copy: bool,
    /// Reaches other processes of the machine.
    pub cross_process: bool,
    /// Reaches other machines.
    pub cross_host: bool,
    /// Serves and calls services.
    pub services: bool,
    /// Shows services to peers that are no genomd.
    pub native_services: bool,
}

/// What came from others and was not let in: counted by reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The reason, in the words of the log.
    pub why: &'static str,
    /// How many there were so far.
    pub count: u64,
    /// Who sent the last one, as far as known.
    pub peer: Option<std::net::IpAddr>,
}

/// The optional concerns, for callers that do not care whether a middleware has them: where it has
/// not, they get an error that says so.
impl dyn Middleware + '_ {
    /// As [`Services::serve`].
    ///
    /// # Errors
    /// As there, or the middleware has no services.
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

    /// As [`Services::client`].
    ///
    /// # Errors
    /// As there, or the middleware has no services.
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

    /// As [`Discovery::discover`].
    ///
    /// # Errors
    /// As there, or the middleware does not know who is there.
    pub fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError> {
        self.known()?.discover()
    }

    /// As [`Discovery::ends_at`].
    ///
    /// # Errors
    /// As there, or the middleware does not know who is there.
    pub fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        self.known()?.ends_at(at)
    }

    fn known(&self) -> Result<&dyn Discovery, DiscoverError> {
        self.discovery().ok_or_else(|| DiscoverError {
            backend: self.name().to_owned(),
            why: "it does not know who is there; connect to the address as you know it".to_owned(),
        })
    }

    /// As [`Discovery::spelled`]: the address as it is, where nothing is listed.
    #[must_use]
    pub fn spelled(&self, at: &Address) -> String {
        self.discovery().map_or_else(|| at.to_string(), |discovery| discovery.spelled(at))
    }

    /// As [`Discovery::strangers`]: nobody, where nobody is known.
    #[must_use]
    pub fn strangers(&self) -> Vec<Stranger> {
        self.discovery().map(Discovery::strangers).unwrap_or_default()
    }

    /// As [`Discovery::obstacles`]: none, where nobody is known.
    #[must_use]
    pub fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        self.discovery().map(|discovery| discovery.obstacles(at)).unwrap_or_default()
    }
}
