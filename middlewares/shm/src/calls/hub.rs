//! The serving side of a daemon: receives requests and passes each to the service that it names.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, Weak};

use genom_middleware::describe::types_of_service;
use genom_middleware::{Address, OpenError};
use genom_types::Record;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;

use super::bell::{Bell, lock};
use super::frame;
use super::meeting::{self, CallService, FIRST_ROOM};
use super::request::{Entry, Request, ToCaller, digests, offer, send};
use crate::catalog::Kind;
use crate::error::failed;
use crate::ground::Ground;
use crate::raw::Ipc;

/// Number of responses for which memory is preallocated.
const PREPARED: usize = 512;

pub(super) struct Hub {
    /// By address.
    entries: Mutex<HashMap<String, Arc<Entry>>>,
    requests: Mutex<Vec<Weak<Request>>>,
    server: Server<Ipc, [u8], (), [u8], ()>,
    _service: CallService,
    bell: Arc<Bell>,
    ground: Arc<Ground>,
}

impl Hub {
    pub(super) fn open(
        ground: &Arc<Ground>,
        bell: &Arc<Bell>,
        at: &Address,
    ) -> Result<Self, OpenError> {
        let service = meeting::create(ground, at)?;
        let server = service
            .server_builder()
            .initial_max_slice_len(FIRST_ROOM)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
            .override_response_preallocation(|worst| worst.min(PREPARED))
            .create()
            .map_err(|error| failed(at, &error.to_string()))?;
        Ok(Self {
            entries: Mutex::default(),
            requests: Mutex::default(),
            server,
            _service: service,
            bell: Arc::clone(bell),
            ground: Arc::clone(ground),
        })
    }

    /// Serves `entry` from now on, unless the address is taken.
    pub(super) fn add(&self, at: &Address, entry: &Arc<Entry>) -> Result<(), OpenError> {
        // The server exists before the catalog announces it, so that no request is missed.
        let mut entries = lock(&self.entries);
        self.ground.offer(Kind::Service, at, offer(&entry.ty))?;
        entries.insert(at.to_string(), Arc::clone(entry));
        Ok(())
    }

    /// Withdraws a service: its callers stop waiting.
    pub(super) fn withdraw(&self, at: &Address, entry: &Arc<Entry>) {
        lock(&self.entries).remove(&at.to_string());
        self.ground.withdraw(Kind::Service, at);
        // The handler may keep its requests for long; their callers are notified now.
        let mut ended = Vec::new();
        lock(&self.requests).retain(|request| match request.upgrade() {
            Some(request) if request.is_for(entry) => {
                ended.push(request);
                false
            }
            other => other.is_some(),
        });
        ended.iter().for_each(|request| request.end());
    }

    /// Passes on requests and cancellations that arrived. Holds no lock while a handler runs.
    pub(super) fn work(&self) {
        while let Ok(Some(active)) = self.server.receive() {
            let message = active.payload().to_vec();
            let Some((address, theirs, input)) = frame::read_request(&message) else {
                send(&active, &frame::refused("the request cannot be read"));
                continue;
            };
            let Some(entry) = lock(&self.entries).get(address).cloned() else {
                send(&active, &frame::not_served());
                continue;
            };
            if theirs != digests(&entry.ty) {
                send(&active, &frame::other_types(&types_of_service(&entry.ty)));
                continue;
            }
            let mut record = Record::new(&entry.ty.input);
            if let Err(error) = record.decode_message(input) {
                send(&active, &frame::refused(&format!("the request cannot be decoded: {error}")));
                continue;
            }
            let served = lock(&self.entries);
            // Withdrawn meanwhile; whoever withdrew it ends the request if this does not.
            if !served.get(address).is_some_and(|now| Arc::ptr_eq(now, &entry)) {
                send(&active, &frame::not_served());
                continue;
            }
            let request = Arc::new(Request::new(active, &entry, &self.bell));
            lock(&self.requests).push(Arc::downgrade(&request));
            drop(served);
            entry.handler.request(record, Box::new(ToCaller(request)));
        }
        let requests: Vec<_> = lock(&self.requests).iter().filter_map(Weak::upgrade).collect();
        requests.iter().for_each(|request| request.look_for_the_caller());
        lock(&self.requests).retain(|request| request.strong_count() > 0);
    }
}
