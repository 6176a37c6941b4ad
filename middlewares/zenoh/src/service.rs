//! A service as a queryable: one query, one or more replies.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use genom_middleware::describe::types_of_service;
use genom_middleware::{
    ActivityId, CallError, Outcome, Replies, Served, ServiceHandler, ServiceType,
};
use genom_types::Record;
use serde_json::json;
use zenoh::Wait;
use zenoh::bytes::{Encoding, ZBytes};
use zenoh::query::{Query, Queryable};

use crate::core::Core;
use crate::graph::Claim;
use crate::sending::Orders;
use crate::wire::{self, Expected, Refusal};

/// What the queryable's callback needs.
pub(crate) struct Server {
    pub(crate) ty: ServiceType,
    pub(crate) handler: Arc<dyn ServiceHandler>,
    pub(crate) orders: Orders,
    /// Requests that may still be in progress; their callers are notified when the service is
    /// withdrawn. `None` after that.
    pending: Mutex<Option<Vec<Weak<Request>>>>,
}

/// A request in progress.
struct Request {
    /// Taken with the last reply; dropping it ends the query.
    query: Mutex<Option<Query>>,
    encoding: Encoding,
}

/// Serves until it is dropped.
pub(crate) struct ZenohServed {
    pub(crate) server: Arc<Server>,
    /// The service and, for an activity, its cancellation key; closed before the callers are
    /// notified.
    pub(crate) shown: Option<(Queryable<()>, Option<Queryable<()>>, Claim)>,
    pub(crate) core: Arc<Core>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Server {
    pub(crate) fn new(ty: ServiceType, handler: Arc<dyn ServiceHandler>, orders: Orders) -> Self {
        Self { ty, handler, orders, pending: Mutex::new(Some(Vec::new())) }
    }

    /// A query arrived on the service's own key.
    pub(crate) fn request(&self, query: Query) {
        match self.input(&query) {
            Ok(input) => self.start(query, input),
            Err(refusal) => {
                tracing::warn!(key = %query.key_expr(), "refused a request: {refusal:?}");
                self.orders.submit(move |_, _| refuse(&query, &refusal));
            }
        }
    }

    /// Decodes and checks the input.
    fn input(&self, query: &Query) -> Result<Record, Refusal> {
        let types = || Refusal::Types(types_of_service(&self.ty));
        let digest = self.ty.digest();
        if query.attachment().is_some_and(|theirs| theirs.to_bytes() != digest.as_bytes())
            || query.encoding().is_some_and(|of| !Expected::of(&self.ty.input).admits(of))
        {
            return Err(types());
        }
        let message = query.payload().map(ZBytes::to_bytes).unwrap_or_default();
        let mut input = Record::new(&self.ty.input);
        match input.decode_message(&message) {
            Ok(()) => Ok(input),
            // A service without parameters needs no payload.
            Err(_) if message.is_empty() && self.ty.input.member_count() == 0 => Ok(input),
            Err(error) => Err(Refusal::Serialization(error.to_string())),
        }
    }

    fn start(&self, query: Query, input: Record) {
        let request = Arc::new(Request {
            query: Mutex::new(Some(query)),
            encoding: wire::encoding_of(&self.ty.output),
        });
        match &mut *lock(&self.pending) {
            Some(pending) => {
                pending.retain(|other| other.strong_count() > 0);
                pending.push(Arc::downgrade(&request));
            }
            None => {
                return self.orders.submit(move |_, _| {
                    request.end(|query| {
                        refuse(query, &Refusal::Gone);
                    })
                });
            }
        }
        // The handler may call back into this middleware, so no lock is held here.
        self.handler.request(input, Box::new(ToCaller { request, orders: self.orders.clone() }));
    }

    /// A query arrived on the cancellation key.
    pub(crate) fn cancel(&self, query: Query) {
        let payload = query.payload().map(ZBytes::to_bytes).unwrap_or_default();
        let id = std::str::from_utf8(&payload).ok().and_then(|text| text.trim().parse().ok());
        if let Some(id) = id {
            self.handler.cancel(ActivityId(id));
        }
        self.orders.submit(move |_, _| match id {
            Some(_) => reported(query.reply(query.key_expr().clone(), "").wait()),
            None => {
                let why = "the payload is no number of a run in decimal".to_owned();
                refuse(&query, &Refusal::Serialization(why));
            }
        });
    }

    /// Notifies all waiting callers that the service is withdrawn.
    fn leave(&self) {
        let pending = lock(&self.pending).take();
        for request in pending.into_iter().flatten().filter_map(|request| request.upgrade()) {
            request.end(|query| refuse(query, &Refusal::Gone));
        }
    }
}

fn reported(sent: zenoh::Result<()>) {
    if let Err(error) = sent {
        // The caller may be gone, which is not an error here.
        tracing::debug!(%error, "a reply was not sent");
    }
}

fn refuse(query: &Query, refusal: &Refusal) {
    let error = query.reply_err(refusal.to_json().to_string());
    reported(error.encoding(Encoding::APPLICATION_JSON).wait());
}

impl Request {
    /// Sends the last reply unless it was sent already.
    fn end(&self, answer: impl FnOnce(&Query)) {
        let query = lock(&self.query).take();
        if let Some(query) = query {
            answer(&query);
        }
    }

    /// Sends a reply that is not the last.
    fn tell(&self, kind: &'static [u8], text: String) {
        if let Some(query) = &*lock(&self.query) {
            let reply = query.reply(query.key_expr().clone(), text);
            reported(reply.encoding(Encoding::TEXT_PLAIN).attachment(kind).wait());
        }
    }

    fn finish(&self, outcome: Outcome) {
        self.end(|query| match outcome {
            Outcome::Success(output) => {
                let mut message = Vec::new();
                if let Err(error) = output.encode_message(&mut message) {
                    return refuse(query, &Refusal::Serialization(error.to_string()));
                }
                let reply = query.reply(query.key_expr().clone(), message);
                let reply = reply.encoding(self.encoding.clone());
                reported(reply.attachment(wire::RESULT).wait());
            }
            Outcome::Exception { name, detail } => {
                let text = json!({"exception": name, "detail": detail}).to_string();
                reported(query.reply_err(text).encoding(Encoding::APPLICATION_JSON).wait());
            }
            Outcome::Lost(CallError::Gone) => refuse(query, &Refusal::Gone),
            Outcome::Lost(error) => refuse(query, &Refusal::Failed(error.to_string())),
        });
    }
}

/// Passes the service's replies on to the caller; the session's sending thread sends them.
struct ToCaller {
    request: Arc<Request>,
    orders: Orders,
}

impl Replies for ToCaller {
    fn accepted(&mut self, id: ActivityId) {
        let request = Arc::clone(&self.request);
        self.orders.submit(move |_, _| request.tell(wire::ACCEPTED, id.to_string()));
    }

    fn feedback(&mut self, state: &str) {
        let (request, state) = (Arc::clone(&self.request), state.to_owned());
        self.orders.submit(move |_, _| request.tell(wire::FEEDBACK, state));
    }

    fn finish(self: Box<Self>, outcome: Outcome) {
        let request = Arc::clone(&self.request);
        self.orders.submit(move |_, _| request.finish(outcome));
    }
}

impl Drop for ToCaller {
    // Has no effect after `finish`.
    fn drop(&mut self) {
        let request = Arc::clone(&self.request);
        self.orders.submit(move |_, _| request.finish(Outcome::Lost(CallError::Gone)));
    }
}

impl Served for ZenohServed {}

impl Drop for ZenohServed {
    fn drop(&mut self) {
        self.shown = None;
        let server = Arc::clone(&self.server);
        // On the sending thread, so that earlier replies are sent first.
        self.core.orders().finish(move |_, _| server.leave());
    }
}
