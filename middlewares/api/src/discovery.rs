//! Who is on a middleware: ends of ports, services, and programs of other makes.

use crate::{Address, DiscoverError};

/// Lists ports and services on a middleware. One whose peers do not announce themselves does not
/// implement this.
pub trait Discovery {
    /// What is visible now, ours and others'.
    ///
    /// # Errors
    /// When the middleware cannot tell.
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError>;

    /// Ends of ports at one address, of those that [`discover`](Discovery::discover) lists: for
    /// callers that ask for many addresses, where listing everything each time costs more.
    ///
    /// # Errors
    /// As there.
    fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        let wanted = self.spelled(at);
        Ok(self.discover()?.into_iter().filter(|end| end.address == wanted).collect())
    }

    /// How [`discover`](Discovery::discover) spells an address: with the namespace of this side in
    /// front, where there is one.
    fn spelled(&self, at: &Address) -> String {
        at.to_string()
    }

    /// Programs that are connected but do not show in [`discover`](Discovery::discover), as far as
    /// the middleware tells of them. For diagnosis by people.
    fn strangers(&self) -> Vec<Stranger> {
        Vec::new()
    }

    /// What keeps our ends at an address and others from meeting, though both are there.
    fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        let _ = at;
        Vec::new()
    }
}

/// What an endpoint is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EndpointKind {
    /// An out port.
    Publisher,
    /// An in port.
    Subscription,
    /// A service.
    Service,
}

/// Something visible on a middleware.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Endpoint {
    /// Out port, in port or service.
    pub kind: EndpointKind,
    /// In the middleware's own spelling: `demo/position` for ours.
    pub address: String,
    /// Name of its type, as far as known.
    pub ty: String,
}

/// Somebody on a middleware who does not tell what it opens, as programs of other makes may.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Stranger {
    /// Somebody reads an out port of this side; as which type is not known.
    Reader {
        /// Of the out port.
        address: String,
    },
    /// Somebody is connected; what it opened cannot be seen.
    Session {
        /// By which the middleware tells it from others.
        name: String,
        /// What it is there, in the middleware's own words.
        role: &'static str,
    },
}

/// Why two ends that are there are not connected, or get less from each other than they could.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Obstacle {
    /// What is in the way, as a sentence without a stop.
    pub what: String,
    /// What to do.
    pub fix: String,
}
