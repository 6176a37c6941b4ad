//! The serving end.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError, Weak};

use genom_middleware::{
    ActivityId, Address, CallError, OpenError, Outcome, Replies, Served, ServiceHandler,
    ServiceType,
};
use genom_types::{CdrError, Record};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::server::Server as RawServer;
use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::server::ServerCreateError;

use super::worker::Bell;
use super::{CallService, FIRST_ROOM, frame, service};
use crate::backend::{Inner, failed};
use crate::raw::Ipc;

type Active = ActiveRequest<Ipc, [u8], (), [u8], ()>;

/// Memory for responses that is made beforehand.
const PREPARED: usize = 96;

/// What the worker looks after.
pub(super) struct Server {
    /// Taken when the service is withdrawn, though the worker may be looking at it.
    port: Mutex<Option<Port>>,
    requests: Mutex<Vec<Weak<Request>>>,
    handler: Arc<dyn ServiceHandler>,
    ty: ServiceType,
    bell: Arc<Bell>,
}

struct Port {
    server: RawServer<Ipc, [u8], (), [u8], ()>,
    _service: CallService,
}

/// One request under way.
struct Request {
    /// Taken when it ends; its drop tells the caller.
    active: Mutex<Option<Active>>,
    id: OnceLock<ActivityId>,
    cancelled: AtomicBool,
    bell: Arc<Bell>,
}

struct ShmServed {
    server: Arc<Server>,
    _inner: Arc<Inner>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
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
    let server = Arc::new(Server {
        port: Mutex::new(Some(Port { server: port, _service: service })),
        requests: Mutex::default(),
        handler,
        ty: ty.clone(),
        bell: Arc::clone(worker.bell()),
    });
    worker.add_server(&server);
    Ok(ShmServed { server, _inner: Arc::clone(inner) })
}

impl Served for ShmServed {}

impl Drop for ShmServed {
    fn drop(&mut self) {
        let port = lock(&self.server.port).take();
        // The handler may keep requests for long: their callers wait no more.
        for request in lock(&self.server.requests).drain(..).filter_map(|r| r.upgrade()) {
            drop(lock(&request.active).take());
        }
        drop(port);
        self.server.bell.ring();
    }
}

impl Server {
    /// Hands on what arrived, and what callers gave up.
    pub(super) fn work(&self) {
        while let Some((request, input)) = self.next() {
            match input {
                Ok(input) => self.handler.request(input, Box::new(ToCaller(request))),
                Err(error) => {
                    let why = format!("the request cannot be decoded: {error}");
                    request.send(&frame::refused(&why));
                    request.end();
                }
            }
        }
        let requests: Vec<_> = lock(&self.requests).iter().filter_map(Weak::upgrade).collect();
        for request in requests {
            let Some(id) = request.id.get() else { continue };
            let given_up = lock(&request.active).as_ref().is_some_and(Active::has_disconnect_hint);
            if given_up && !request.cancelled.swap(true, Ordering::SeqCst) {
                self.handler.cancel(*id);
            }
        }
        lock(&self.requests).retain(|request| request.strong_count() > 0);
    }

    /// The next request, listed before the service can be withdrawn.
    fn next(&self) -> Option<(Arc<Request>, Result<Record, CdrError>)> {
        let port = lock(&self.port);
        let active = port.as_ref()?.server.receive().ok().flatten()?;
        let mut input = Record::new(&self.ty.input);
        let read = input.decode_message(active.payload());
        let request = Arc::new(Request {
            active: Mutex::new(Some(active)),
            id: OnceLock::new(),
            cancelled: AtomicBool::new(false),
            bell: Arc::clone(&self.bell),
        });
        lock(&self.requests).push(Arc::downgrade(&request));
        Some((request, read.map(|()| input)))
    }
}

impl Request {
    fn send(&self, frame: &[u8]) {
        if let Some(active) = &*lock(&self.active) {
            let loan = active.loan_slice_uninit(frame.len());
            let sent = loan.is_ok_and(|loan| loan.write_from_slice(frame).send().is_ok());
            if !sent {
                tracing::warn!("a response was lost: its caller is gone, or does not keep up");
            }
        }
        self.bell.ring();
    }

    fn end(&self) {
        drop(lock(&self.active).take());
        self.bell.ring();
    }
}

/// What the service gets as the caller's replies.
struct ToCaller(Arc<Request>);

impl Replies for ToCaller {
    fn accepted(&mut self, id: ActivityId) {
        let _ = self.0.id.set(id);
        self.0.send(&frame::accepted(id));
    }

    fn feedback(&mut self, state: &str) {
        self.0.send(&frame::feedback(state));
    }

    fn finish(self: Box<Self>, outcome: Outcome) {
        if let Outcome::Lost(CallError::Serialization(why)) = &outcome {
            self.0.send(&frame::refused(why));
        } else if let Some(frame) = frame::finished(&outcome) {
            self.0.send(&frame);
        }
    }
}

impl Drop for ToCaller {
    fn drop(&mut self) {
        self.0.end();
    }
}
