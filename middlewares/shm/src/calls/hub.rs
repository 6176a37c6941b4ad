//! The serving side of a daemon: receives requests and passes each to the service that it names.

use std::collections::HashMap;
use std::sync::{Arc, Condvar, Mutex, PoisonError, Weak};
use std::thread::{self, ThreadId};
use std::time::Duration;

use genom_middleware::describe::types_of_service;
use genom_middleware::{Address, OpenError};
use genom_types::Record;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::*;

use super::bell::{Bell, lock};
use super::frame;
use super::meeting::{self, CallService, FIRST_ROOM};
use super::request::{Active, Entry, Request, ToCaller, digests, offer, send};
use crate::catalog::Kind;
use crate::error::failed;
use crate::ground::Ground;
use crate::raw::Ipc;

/// Number of responses for which memory is preallocated.
const PREPARED: usize = 512;

/// How long to wait, where a service is withdrawn, for a handler that does not return.
const TO_RETURN: Duration = Duration::from_secs(1);

/// What the thread of requests holds of services while it works.
#[derive(Clone, Copy)]
struct Busy {
    thread: ThreadId,
    /// Number of the service whose handler it calls; `None` while it looks for one, or after requests
    /// of all.
    serves: Option<usize>,
}

impl Busy {
    /// Whether another thread holds this service. What a handler withdraws itself, it holds.
    fn holds(&self, number: usize) -> bool {
        self.thread != thread::current().id() && self.serves.is_none_or(|serves| serves == number)
    }
}

/// Tells a service from others.
fn number(entry: &Arc<Entry>) -> usize {
    Arc::as_ptr(entry).addr()
}

pub(super) struct Hub {
    /// By address.
    entries: Mutex<HashMap<String, Arc<Entry>>>,
    requests: Mutex<Vec<Weak<Request>>>,
    busy: Mutex<Option<Busy>>,
    /// Nothing is held any more.
    idle: Condvar,
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
            busy: Mutex::default(),
            idle: Condvar::new(),
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
        drop(ended);
        // What the handler holds is closed with the last reference to it, which is the caller's now.
        let number = number(entry);
        let held = |busy: &mut Option<Busy>| busy.is_some_and(|busy| busy.holds(number));
        let waited = self.idle.wait_timeout_while(lock(&self.busy), TO_RETURN, held);
        let (busy, waited) = waited.unwrap_or_else(PoisonError::into_inner);
        drop(busy);
        if waited.timed_out() {
            tracing::warn!(service = %at, "its handler does not return: what it holds is closed later");
        }
    }

    /// Passes on requests and cancellations that arrived. Holds no lock while a handler runs.
    pub(super) fn work(&self) {
        while let Ok(Some(active)) = self.server.receive() {
            self.busy_with(None);
            self.serve(active);
            self.rest();
        }
        self.busy_with(None);
        let requests: Vec<_> = lock(&self.requests).iter().filter_map(Weak::upgrade).collect();
        requests.iter().for_each(|request| request.look_for_the_caller());
        drop(requests);
        self.rest();
        lock(&self.requests).retain(|request| request.strong_count() > 0);
    }

    fn busy_with(&self, serves: Option<usize>) {
        *lock(&self.busy) = Some(Busy { thread: thread::current().id(), serves });
    }

    fn rest(&self) {
        *lock(&self.busy) = None;
        self.idle.notify_all();
    }

    fn serve(&self, active: Active) {
        let message = active.payload().to_vec();
        let Some((address, theirs, input)) = frame::read_request(&message) else {
            return send(&active, &frame::refused("the request cannot be read"));
        };
        let Some(entry) = lock(&self.entries).get(address).cloned() else {
            return send(&active, &frame::not_served());
        };
        if theirs != digests(&entry.ty) {
            return send(&active, &frame::other_types(&types_of_service(&entry.ty)));
        }
        let mut record = Record::new(&entry.ty.input);
        if let Err(error) = record.decode_message(input) {
            let why = format!("the request cannot be decoded: {error}");
            return send(&active, &frame::refused(&why));
        }
        let served = lock(&self.entries);
        // Withdrawn meanwhile; whoever withdrew it ends the request if this does not.
        if !served.get(address).is_some_and(|now| Arc::ptr_eq(now, &entry)) {
            return send(&active, &frame::not_served());
        }
        let request = Arc::new(Request::new(active, &entry, &self.bell));
        lock(&self.requests).push(Arc::downgrade(&request));
        drop(served);
        self.busy_with(Some(number(&entry)));
        entry.handler.request(record, Box::new(ToCaller(request)));
    }
}
