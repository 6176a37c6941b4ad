//! What arrived at a service and was not answered yet, as the worker sees it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock, Weak};

use genom_middleware::{ActivityId, CallError, Outcome, Replies, ServiceHandler, ServiceType};
use genom_types::{CdrError, Record};
use iceoryx2::active_request::ActiveRequest;
use iceoryx2::port::server::Server as RawServer;

use super::bell::{Bell, lock};
use super::frame;
use super::service::CallService;
use crate::raw::Ipc;

type Active = ActiveRequest<Ipc, [u8], (), [u8], ()>;

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

impl Server {
    pub(super) fn new(
        server: RawServer<Ipc, [u8], (), [u8], ()>,
        service: CallService,
        handler: Arc<dyn ServiceHandler>,
        ty: &ServiceType,
        bell: &Arc<Bell>,
    ) -> Self {
        Self {
            port: Mutex::new(Some(Port { server, _service: service })),
            requests: Mutex::default(),
            handler,
            ty: ty.clone(),
            bell: Arc::clone(bell),
        }
    }

    /// The service is there no more: callers wait no longer.
    pub(super) fn withdraw(&self) {
        let port = lock(&self.port).take();
        // The handler may keep requests for long: their callers wait no more.
        for request in lock(&self.requests).drain(..).filter_map(|r| r.upgrade()) {
            drop(lock(&request.active).take());
        }
        drop(port);
        self.bell.ring();
    }

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
