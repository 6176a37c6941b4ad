//! What is behind an in port or a remote.

use genom_middleware::{Address, Policy};

/// What feeds an in port.
#[derive(Clone, Debug)]
pub(crate) struct Connection {
    pub(crate) inport: Address,
    pub(crate) outport: Address,
    pub(crate) backend: String,
    pub(crate) policy: Policy,
    /// Whether the backend was asked for by name: then the connection stays on it.
    pub(crate) fixed: bool,
}

/// The service behind a remote.
#[derive(Clone, Debug)]
pub(crate) struct RemoteConnection {
    pub(crate) remote: Address,
    pub(crate) service: Address,
    /// The middleware it is called through; none within the daemon.
    pub(crate) backend: Option<String>,
    /// Whether the middleware was asked for by name: then calls stay on it.
    pub(crate) fixed: bool,
}

/// A port by its index, or an element of a multiple one.
pub(crate) type Key = (usize, Option<String>);

/// The key of a port, or of an element of a multiple one.
pub(crate) fn key(port: usize, element: Option<&str>) -> Key {
    (port, element.map(str::to_owned))
}
