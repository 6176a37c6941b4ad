//! A request in progress on the serving side.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, OnceLock};

use genom_middleware::{ActivityId, Outcome, Replies, ServiceHandler, ServiceKind, ServiceType};
use iceoryx2::active_request::ActiveRequest;

use super::bell::{Bell, lock};
use super::frame;
use crate::catalog::Offer;
use crate::raw::Ipc;

pub(super) type Active = ActiveRequest<Ipc, [u8], (), [u8], ()>;

/// A service that is being served.
pub(super) struct Entry {
    pub(super) handler: Arc<dyn ServiceHandler>,
    pub(super) ty: ServiceType,
}

fn kind(ty: &ServiceType) -> &'static str {
    match ty.kind {
        ServiceKind::Attribute => "attribute",
        ServiceKind::Function => "function",
        ServiceKind::Activity => "activity",
    }
}

/// The kind and digests of a service. Caller and server must have the same ones.
pub(super) fn digests(ty: &ServiceType) -> String {
    format!("{} {}", kind(ty), ty.digest())
}

/// What the catalog says about a service.
pub(super) fn offer(ty: &ServiceType) -> Offer {
    let spelling = format!("{} {} -> {}", kind(ty), ty.input.name(), ty.output.name());
    Offer { digests: digests(ty), spelling }
}

/// A request in progress.
pub(super) struct Request {
    /// Taken when the request ends. Dropping it notifies the caller.
    active: Mutex<Option<Active>>,
    /// The service that was called.
    entry: Arc<Entry>,
    id: OnceLock<ActivityId>,
    cancelled: AtomicBool,
    bell: Arc<Bell>,
}

impl Request {
    pub(super) fn new(active: Active, entry: &Arc<Entry>, bell: &Arc<Bell>) -> Self {
        Self {
            active: Mutex::new(Some(active)),
            entry: Arc::clone(entry),
            id: OnceLock::new(),
            cancelled: AtomicBool::new(false),
            bell: Arc::clone(bell),
        }
    }

    pub(super) fn is_for(&self, entry: &Arc<Entry>) -> bool {
        Arc::ptr_eq(&self.entry, entry)
    }

    /// If the caller has dropped the request, cancels it at the handler, once.
    pub(super) fn look_for_the_caller(&self) {
        let Some(id) = self.id.get() else { return };
        let given_up = lock(&self.active).as_ref().is_some_and(Active::has_disconnect_hint);
        if given_up && !self.cancelled.swap(true, Ordering::SeqCst) {
            self.entry.handler.cancel(*id);
        }
    }

    pub(super) fn send(&self, frame: &[u8]) {
        if let Some(active) = &*lock(&self.active) {
            send(active, frame);
        }
        self.bell.ring();
    }

    pub(super) fn end(&self) {
        drop(lock(&self.active).take());
        self.bell.ring();
    }
}

/// Sends a response.
pub(super) fn send(active: &Active, frame: &[u8]) {
    let loan = active.loan_slice_uninit(frame.len());
    let sent = loan.is_ok_and(|loan| loan.write_from_slice(frame).send().is_ok());
    if !sent {
        tracing::warn!("a response was lost: its caller is gone, or does not keep up");
    }
}

/// Passes the service's replies on to the caller.
pub(super) struct ToCaller(pub(super) Arc<Request>);

impl Replies for ToCaller {
    fn accepted(&mut self, id: ActivityId) {
        let _ = self.0.id.set(id);
        self.0.send(&frame::accepted(id));
    }

    fn feedback(&mut self, state: &str) {
        self.0.send(&frame::feedback(state));
    }

    fn finish(self: Box<Self>, outcome: Outcome) {
        if let Some(frame) = frame::finished(&outcome) {
            self.0.send(&frame);
        }
    }
}

impl Drop for ToCaller {
    fn drop(&mut self) {
        self.0.end();
    }
}
