//! The serving end.

use std::sync::Arc;

use genom_middleware::{Address, OpenError, Served, ServiceHandler, ServiceType};
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::server::ServerCreateError;

use super::server::Server;
use super::service::{FIRST_ROOM, service};
use crate::error::failed;
use crate::inner::Inner;

/// Memory for responses that is made beforehand.
const PREPARED: usize = 96;

struct ShmServed {
    server: Arc<Server>,
    _inner: Arc<Inner>,
}

/// Serves until the result is dropped.
pub(crate) fn open(
    inner: &Arc<Inner>,
    at: &Address,
    ty: &ServiceType,
    handler: Arc<dyn ServiceHandler>,
) -> Result<impl Served + 'static, OpenError> {
    let worker = inner.worker(at)?;
    let service = service(&inner.ground, at, ty)?;
    let create = || {
        service
            .server_builder()
            .initial_max_slice_len(FIRST_ROOM)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .override_response_preallocation(|worst| worst.min(PREPARED))
            .create()
    };
    let port = match create() {
        // The server may be one that was killed.
        Err(ServerCreateError::ExceedsMaxSupportedServers)
            if inner.ground.node.try_cleanup_dead_nodes().cleanups > 0 =>
        {
            create()
        }
        other => other,
    };
    let port = port.map_err(|error| match error {
        ServerCreateError::ExceedsMaxSupportedServers => OpenError::Taken { address: at.clone() },
        other => failed(at, &other.to_string()),
    })?;
    let server = Arc::new(Server::new(port, service, handler, ty, worker.bell()));
    worker.add_server(&server);
    Ok(ShmServed { server, _inner: Arc::clone(inner) })
}

impl Served for ShmServed {}

impl Drop for ShmServed {
    fn drop(&mut self) {
        self.server.withdraw();
    }
}
