//! Discovery: which ports and services exist on a middleware, including those of programs that are
//! not genomd.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use crate::{Address, DiscoverError};

/// Lists ports and services on a middleware. Backends whose peers do not announce themselves do not
/// implement it.
pub trait Discovery {
    /// Everything that is visible now, whether it belongs to this daemon or to others.
    ///
    /// # Errors
    /// When the middleware cannot list it.
    fn discover(&self) -> Result<Vec<Endpoint>, DiscoverError>;

    /// The ports at one address, out of those that [`discover`](Discovery::discover) lists.
    /// Backends override it where listing everything for each of many addresses would be slow.
    ///
    /// # Errors
    /// The same as [`discover`](Discovery::discover).
    fn ends_at(&self, at: &Address) -> Result<Vec<Endpoint>, DiscoverError> {
        let wanted = self.spelled(at);
        Ok(self.discover()?.into_iter().filter(|end| end.address == wanted).collect())
    }

    /// The address as [`discover`](Discovery::discover) spells it: with the namespace of this side
    /// in front, if there is one.
    fn spelled(&self, at: &Address) -> String {
        at.to_string()
    }

    /// Peers that are connected but not listed by [`discover`](Discovery::discover), as far as the
    /// middleware knows of them. Shown to people who look for a fault.
    fn strangers(&self) -> Vec<Stranger> {
        Vec::new()
    }

    /// Reasons why our ports at an address and those of others do not connect although both exist.
    fn obstacles(&self, at: &Address) -> Vec<Obstacle> {
        let _ = at;
        Vec::new()
    }
}

/// Kind of an endpoint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum EndpointKind {
    /// An out port.
    Publisher,
    /// An in port.
    Subscription,
    /// A service.
    Service,
}

/// Something visible on a middleware.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Endpoint {
    /// Out port, in port or service.
    pub kind: EndpointKind,
    /// Address in the middleware's own spelling; `demo/position` for ours.
    pub address: String,
    /// Name of its type; empty if unknown.
    pub ty: String,
}

/// A peer that does not announce what it opens, as programs that are not genomd may not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Stranger {
    /// A reader of one of our out ports; the type that it expects is unknown.
    Reader {
        /// Address of the out port.
        address: String,
    },
    /// A connected peer; what it opened is not visible.
    Session {
        /// Identity of the peer on the middleware.
        name: String,
        /// Role of the peer, in the middleware's terms.
        role: Cow<'static, str>,
    },
}

/// Why two existing ends are not connected, or exchange less than they could.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Obstacle {
    /// The cause, as a sentence without a full stop.
    pub what: String,
    /// What to do about it.
    pub fix: String,
}
