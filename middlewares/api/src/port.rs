//! Ports on a middleware: publishers, subscriptions, discovery.

use std::sync::Arc;

use genom_types::{DataType, Record};

use crate::service::{Client, Served, ServiceHandler, ServiceType};
use crate::{Address, DiscoverError, Obstacle, OpenError, PublishError, Quality, ReadError, Relay};

/// What a reader wants of the samples it has not read yet.
///
/// Whatever the policy, a new reader starts with the last value, if there is one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Policy {
    /// The newest value only: the semantics of GenoM ports.
    #[default]
    Latest,
    /// Oldest first, at most this many unread; when full, new samples are dropped and counted.
    Queue(usize),
    /// Oldest first, at most this many unread; when full, the oldest are overwritten and counted.
    Ring(usize),
}

/// What a read found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reading {
    /// A sample that had not been read before is now in the record.
    New,
    /// Nothing new: the record still holds the last value.
    Same,
    /// Nothing was ever published.
    Never,
}

/// The writing end of an out port (or of one element of a multiple port).
///
/// The last value is offered to late readers as long as the publisher lives. Dropping it frees
/// the address; readers keep what they have read.
pub trait Publisher: Send {
    /// Publishes a copy of the value; a reader that comes later still sees it.
    ///
    /// Real-time: a bounded copy, no blocking, and no allocation of ours for types of fixed size.
    ///
    /// # Errors
    /// When the value has no encoding or the middleware refuses it; nothing was published then.
    fn publish(&mut self, value: &Record) -> Result<(), PublishError>;

    /// Samples given up so far because the middleware did not keep up.
    fn dropped(&self) -> u64;
}

/// The reading end of an in port (or of one element of a multiple port).
pub trait Subscription: Send {
    /// Puts the next value, by the connection's policy, into `into`.
    ///
    /// Real-time as [`Publisher::publish`]. `into` is of the type the subscription was opened
    /// with, and is left alone unless the result is [`Reading::New`].
    ///
    /// # Errors
    /// When the sample is not decodable or the middleware fails.
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError>;

    /// Samples lost so far: overwritten (ring), refused (queue) or undecodable.
    fn dropped(&self) -> u64;
}

/// What a middleware can do; the daemon refuses at load what it cannot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
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

/// What an endpoint is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum EndpointKind {
    /// An out port.
    Publisher,
    /// An in port.
    Subscription,
    /// A service.
    Service,
}

/// Something visible on a middleware.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Endpoint {
    /// What it is.
    pub kind: EndpointKind,
    /// Its name, in the middleware's own spelling: `demo/position` for ours.
    pub address: String,
    /// Name of its type, as far as known.
    pub ty: String,
}

/// Somebody on a middleware who does not tell what it opens, as programs of other makes may.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Stranger {
    /// Somebody reads an out port of this side; as which type is not known.
    Reader {
        /// The port.
        address: String,
    },
    /// Somebody is connected; what it opened cannot be seen.
    Session {
        /// Its name on the middleware.
        name: String,
        /// What it is there, in the middleware's own words.
        role: &'static str,
    },
}

/// What came from others and was not let in: counted by reason.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Refused {
    /// Why, in the words of the log.
    pub why: &'static str,
    /// How many there were so far.
    pub count: u64,
    /// Who sent the last one, as far as known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peer: Option<std::net::IpAddr>,
}

/// A middleware, open and ready. One value serves a whole daemon.
pub trait Middleware: Send + Sync {
    /// Short name: `local`, `shm`, `zenoh`, `ros2`.
    fn name(&self) -> &'static str;

    /// What it can do.
    fn capabilities(&self) -> Capabilities;

    /// What a program of another make must be told to meet the ports of this middleware, by name:
    /// nothing, when all on the machine or the network meet.
    fn meeting_point(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }

    /// Opens the writing end of a port. It shows at once; its value is undefined until written.
    ///
    /// # Errors
    /// When the address is taken, the type differs from a reader's, or the middleware fails.
    fn publisher(&self, at: &Address, ty: &DataType) -> Result<Box<dyn Publisher>, OpenError>;

    /// Opens the reading end of a port. The writer may come later, go and come back.
    ///
    /// # Errors
    /// When the writer's type differs (both are named), or the middleware fails.
    fn subscription(
        &self,
        at: &Address,
        ty: &DataType,
        policy: Policy,
    ) -> Result<Box<dyn Subscription>, OpenError>;

    /// As [`publisher`](Middleware::publisher), of this quality where the middleware has a choice.
    ///
    /// # Errors
    /// As there.
    fn publisher_of(
        &self,
        at: &Address,
        ty: &DataType,
        quality: &Quality,
    ) -> Result<Box<dyn Publisher>, OpenError> {
        let _ = quality;
        self.publisher(at, ty)
    }

    /// As [`subscription`](Middleware::subscription), of this quality where the middleware has a
    /// choice.
    ///
    /// # Errors
    /// As there.
    fn subscription_of(
        &self,
        at: &Address,
        ty: &DataType,
        policy: Policy,
        quality: &Quality,
    ) -> Result<Box<dyn Subscription>, OpenError> {
        let _ = quality;
        self.subscription(at, ty, policy)
    }

    /// Who is there and is not seen by [`discover`](Middleware::discover), as far as that can be
    /// told; for people who look.
    fn strangers(&self) -> Vec<Stranger> {
        Vec::new()
    }

    /// How [`discover`](Middleware::discover) spells an address: with the namespace of this side in
    /// front, where there is one.
    fn spelled(&self, at: &Address) -> String {
        at.to_string()
    }

    /// Ends of ports at one address, as [`discover`](Middleware::discover) tells of all: for who
    /// asks at many addresses, where telling all costs more.
    ///
    /// # Errors
    /// As there.
    fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        let wanted = self.spelled(at);
        Ok(self.discover()?.into_iter().filter(|end| end.address == wanted).collect())
    }

    /// What keeps our ends at an address and others from meeting, though both are there.
    fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        let _ = at;
        Vec::new()
    }

    /// What peers sent that would have harmed, and was refused.
    fn refused(&self) -> Vec<Refused> {
        Vec::new()
    }

    /// Serves a service until the result is dropped. A backend without services refuses.
    ///
    /// # Errors
    /// When the address is served already, or the middleware cannot serve.
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError> {
        let _ = (at, handler);
        Err(self.without_services(service))
    }

    /// Opens the calling end of a service. The service may come later, go and come back.
    ///
    /// # Errors
    /// When the middleware cannot call.
    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError> {
        let _ = at;
        Err(self.without_services(service))
    }

    /// The refusal of a backend that has no services.
    #[doc(hidden)]
    fn without_services(&self, service: &ServiceType) -> OpenError {
        OpenError::Unsupported {
            backend: self.name().to_owned(),
            ty: service.input.name().to_owned(),
            why: "it has no services; bind the service to another backend".to_owned(),
        }
    }

    /// The way to other daemons on this middleware, if it has one.
    fn relay(&self) -> Option<&dyn Relay> {
        None
    }

    /// Shows a type or service (`::demo::pose`, by its full name) as one of the middleware's own,
    /// from now on. A backend without such types has nothing to do.
    ///
    /// # Errors
    /// The foreign name is none; the text says what would be.
    fn masquerade(&self, ours: &str, foreign: &str) -> Result<(), String> {
        let _ = (ours, foreign);
        Ok(())
    }

    /// What is visible now, ours and others'.
    ///
    /// # Errors
    /// When the middleware cannot tell.
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError>;
}
