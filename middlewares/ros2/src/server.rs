//! Attributes and functions, each served as a ROS service.

use std::sync::{Arc, Mutex, Weak};

use genom_kit::complaints::Complaints;
use genom_middleware::{
    ActivityId, CallError, Outcome, Replies, Served, ServiceHandler, ServiceType,
};

use crate::body::{self, Fields, Style};
use crate::lock::lock;
use crate::nodes::Part;
use crate::rmw::{Claim, Reply, Rmw, ServerEnd};

/// A served attribute or function.
pub(crate) struct Server {
    pub(crate) ty: ServiceType,
    pub(crate) style: Style,
    pub(crate) handler: Arc<dyn ServiceHandler>,
    /// Requests in progress; their callers are notified when the service is withdrawn.
    pending: Mutex<Vec<Weak<Request>>>,
    bad: Complaints,
}

struct Request {
    server: Weak<Server>,
    /// Taken with the reply.
    reply: Mutex<Option<Box<dyn Reply>>>,
}

impl Server {
    pub(crate) fn new(
        ty: ServiceType,
        style: Style,
        handler: Arc<dyn ServiceHandler>,
    ) -> Arc<Self> {
        let pending = Mutex::default();
        Arc::new(Self { ty, style, handler, pending, bad: Complaints::default() })
    }

    pub(crate) fn request(self: &Arc<Self>, reply: Box<dyn Reply>, message: &[u8]) {
        let reply = Mutex::new(Some(reply));
        let request = Arc::new(Request { server: Arc::downgrade(self), reply });
        let input = Fields::of(message).map(|fields| fields.record(&self.ty.input));
        match input {
            Some(Ok(input)) => {
                let mut pending = lock(&self.pending);
                pending.retain(|other| other.strong_count() > 0);
                pending.push(Arc::downgrade(&request));
                drop(pending);
                self.handler.request(input, Box::new(ToCaller(request)));
            }
            Some(Err(error)) => {
                if let Some(requests) = self.bad.add() {
                    tracing::warn!(%error, requests, "requests cannot be decoded");
                }
                request.end(&Outcome::Lost(CallError::Serialization(error.to_string())));
            }
            None => {}
        }
    }

    fn leave(&self) {
        let pending = std::mem::take(&mut *lock(&self.pending));
        let requests = pending.iter().filter_map(Weak::upgrade);
        requests.for_each(|request| request.end(&Outcome::Lost(CallError::Gone)));
    }
}

impl Request {
    fn end(&self, outcome: &Outcome) {
        let reply = lock(&self.reply).take();
        if let (Some(reply), Some(server)) = (reply, self.server.upgrade()) {
            let mut body = Vec::new();
            if body::put_outcome(&mut body, &server.ty.output, outcome, server.style) {
                reply.send(body);
            } else {
                // A ROS service cannot report failure: without a reply, its client waits until its
                // timeout.
                tracing::warn!(service = server.ty.input.name(), ?outcome, "no reply can say this");
            }
        }
    }
}

/// Passes the service's replies on to the client.
struct ToCaller(Arc<Request>);

impl Replies for ToCaller {
    fn accepted(&mut self, _: ActivityId) {}

    fn feedback(&mut self, _: &str) {}

    fn finish(self: Box<Self>, outcome: Outcome) {
        self.0.end(&outcome);
    }
}

impl Drop for ToCaller {
    // Has no effect after `finish`, which takes the reply.
    fn drop(&mut self) {
        self.0.end(&Outcome::Lost(CallError::Gone));
    }
}

/// Serves until it is dropped.
pub(crate) struct Ros2Served {
    pub(crate) server: Arc<Server>,
    pub(crate) end: Box<dyn ServerEnd>,
    pub(crate) claim: Option<Box<dyn Claim>>,
    /// What it is to its node.
    pub(crate) part: Option<Part>,
    pub(crate) rmw: Arc<dyn Rmw>,
}

impl Served for Ros2Served {}

impl Drop for Ros2Served {
    fn drop(&mut self) {
        // Withdraw the service before answering the last requests.
        self.part = None;
        self.end.withdraw();
        self.claim = None;
        self.rmw.settle();
        self.server.leave();
        self.end.flush();
    }
}
