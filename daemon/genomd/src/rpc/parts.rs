//! What handlers take of the daemon: each names the part that it uses as an argument.

use std::sync::Arc;

use axum::extract::FromRef;
use genom_doors::Streams;
use genom_supervisor::Supervisor;

use crate::daemon::Daemon;
use crate::startup::Startup;

/// The daemon, as routers hold it.
#[derive(Clone)]
pub(super) struct Parts(pub(super) Arc<Daemon>);

impl FromRef<Parts> for Arc<Supervisor> {
    fn from_ref(parts: &Parts) -> Self {
        Self::clone(&parts.0.supervisor)
    }
}

impl FromRef<Parts> for Arc<Startup> {
    fn from_ref(parts: &Parts) -> Self {
        Self::clone(&parts.0.startup)
    }
}

impl FromRef<Parts> for Streams {
    fn from_ref(parts: &Parts) -> Self {
        parts.0.streams.clone()
    }
}

/// For the few that tell of the daemon itself, or of others.
impl FromRef<Parts> for Arc<Daemon> {
    fn from_ref(parts: &Parts) -> Self {
        Self::clone(&parts.0)
    }
}
