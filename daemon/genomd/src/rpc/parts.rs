//! Parts of the daemon as arguments of handlers: each handler names what it uses.

use std::sync::Arc;

use axum::extract::FromRef;
use genom_cells::{BlackBoxes, Cells, Kept};
use genom_doors::Streams;
use genom_supervisor::Supervisor;

use crate::daemon::Daemon;
use genom_supervisor::bus::startup::Startup;

/// The state of routers: the daemon.
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

impl FromRef<Parts> for Arc<Cells> {
    fn from_ref(parts: &Parts) -> Self {
        Self::clone(&parts.0.cells)
    }
}

impl FromRef<Parts> for Arc<BlackBoxes> {
    fn from_ref(parts: &Parts) -> Self {
        Self::clone(&parts.0.boxes)
    }
}

impl FromRef<Parts> for Arc<Kept> {
    fn from_ref(parts: &Parts) -> Self {
        Self::clone(&parts.0.kept)
    }
}

/// The whole daemon, for the few handlers that describe it or concern other daemons.
impl FromRef<Parts> for Arc<Daemon> {
    fn from_ref(parts: &Parts) -> Self {
        Self::clone(&parts.0)
    }
}
