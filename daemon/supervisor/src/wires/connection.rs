//! What is behind an in port or a remote.

use genom_middleware::{Address, Policy};

/// What feeds an in port.
#[derive(Clone, Debug)]
pub struct Connection {
    /// The in port.
    pub inport: Address,
    /// The out port that feeds it.
    pub outport: Address,
    /// The middleware between them.
    pub backend: String,
    /// What the reader gets of the samples it has not read.
    pub policy: Policy,
    /// Whether the backend was asked for by name: then the connection stays on it.
    pub fixed: bool,
}

/// The service behind a remote.
#[derive(Clone, Debug)]
pub struct RemoteConnection {
    /// The remote.
    pub remote: Address,
    /// The service that it calls.
    pub service: Address,
    /// The middleware it is called through; none within the daemon.
    pub backend: Option<String>,
    /// Whether the middleware was asked for by name: then calls stay on it.
    pub fixed: bool,
}
