//! The calling side of a daemon: one client for each daemon that it called.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use genom_middleware::{Address, OpenError};
use iceoryx2::port::client::Client;
use iceoryx2::prelude::*;

use super::bell::lock;
use super::meeting::{self, CallService, FIRST_ROOM};
use crate::catalog::Kind;
use crate::error::failed;
use crate::ground::Ground;
use crate::raw::Ipc;

/// Number of requests for which memory is preallocated.
const PREPARED: usize = 160;

/// The connection to one daemon.
pub(super) struct Way {
    pub(super) client: Client<Ipc, [u8], (), [u8], ()>,
    service: CallService,
}

#[derive(Default)]
pub(super) struct Callers {
    ways: Mutex<HashMap<u128, Arc<Way>>>,
}

impl Callers {
    /// The connection to the daemon that serves the address; `None` if nobody does.
    pub(super) fn way(&self, ground: &Ground, at: &Address) -> Result<Option<Arc<Way>>, OpenError> {
        for (owner, _) in ground.find(Kind::Service, at) {
            if let Some(way) = self.way_to(ground, owner, at)? {
                return Ok(Some(way));
            }
        }
        Ok(None)
    }

    fn way_to(
        &self,
        ground: &Ground,
        owner: u128,
        at: &Address,
    ) -> Result<Option<Arc<Way>>, OpenError> {
        let mut ways = lock(&self.ways);
        ways.retain(|_, way| way.service.dynamic_config().number_of_servers() > 0);
        if let Some(way) = ways.get(&owner) {
            return Ok(Some(Arc::clone(way)));
        }
        let Some(service) = meeting::open(ground, owner, at)? else { return Ok(None) };
        if service.dynamic_config().number_of_servers() == 0 {
            return Ok(None);
        }
        let client = service
            .client_builder()
            .initial_max_slice_len(FIRST_ROOM)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .override_request_preallocation(|worst| worst.min(PREPARED))
            .create()
            .map_err(|error| failed(at, &error.to_string()))?;
        let way = Arc::new(Way { client, service });
        ways.insert(owner, Arc::clone(&way));
        Ok(Some(way))
    }

    /// Closes all connections.
    pub(super) fn clear(&self) {
        lock(&self.ways).clear();
    }
}
