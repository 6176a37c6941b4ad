//! A request in progress on the calling side: passes responses on to the caller.

use std::sync::{Arc, Mutex};

use genom_middleware::describe::types_of_service;
use genom_middleware::{Address, CallError, Outcome, Replies, ServiceType};
use iceoryx2::pending_response::PendingResponse;

use super::bell::{Bell, lock};
use super::frame::{self, Response};
use crate::raw::Ipc;

pub(super) type Pending = PendingResponse<Ipc, [u8], (), [u8], ()>;

/// A request in progress, as the worker thread sees it.
pub(super) struct Call {
    /// Dropped when the request ends.
    pending: Mutex<Option<Pending>>,
    /// Taken when the request ends.
    replies: Mutex<Option<Box<dyn Replies>>>,
    at: Address,
    ty: ServiceType,
    bell: Arc<Bell>,
}

impl Call {
    pub(super) fn new(
        pending: Pending,
        replies: Box<dyn Replies>,
        at: &Address,
        ty: &ServiceType,
        bell: &Arc<Bell>,
    ) -> Self {
        let (pending, replies) = (Mutex::new(Some(pending)), Mutex::new(Some(replies)));
        Self { pending, replies, at: at.clone(), ty: ty.clone(), bell: Arc::clone(bell) }
    }

    /// Asks the server to cancel the activity.
    pub(super) fn cancel(&self) {
        if let Some(pending) = &*lock(&self.pending) {
            pending.set_disconnect_hint();
        }
        self.bell.ring();
    }

    /// Passes on the responses that arrived. Returns whether the request has ended.
    pub(super) fn work(&self) -> bool {
        loop {
            // Check the connection before receiving, so that responses sent before it closed are
            // still received.
            let (response, over) = match &*lock(&self.pending) {
                Some(pending) => {
                    let over = !pending.is_connected();
                    match pending.receive() {
                        Ok(Some(response)) => {
                            (Some(frame::read(response.payload(), &self.ty.output)), over)
                        }
                        Ok(None) => (None, over),
                        Err(_) => (None, true),
                    }
                }
                None => return true,
            };
            match response {
                Some(Response::Accepted(id)) => {
                    if let Some(replies) = &mut *lock(&self.replies) {
                        replies.accepted(id);
                    }
                }
                Some(Response::Feedback(state)) => {
                    if let Some(replies) = &mut *lock(&self.replies) {
                        replies.feedback(&state);
                    }
                }
                Some(Response::NotServed) => {
                    self.fail(CallError::Nobody { address: self.at.clone() });
                    return true;
                }
                Some(Response::OtherTypes(theirs)) => {
                    let (address, ours) = (self.at.clone(), types_of_service(&self.ty));
                    self.fail(CallError::TypeMismatch { address, ours, theirs });
                    return true;
                }
                Some(Response::Finished(outcome)) => {
                    self.finish(outcome);
                    return true;
                }
                None if over => {
                    self.lose();
                    return true;
                }
                None => return false,
            }
        }
    }

    /// The server went away, or this side closes.
    pub(super) fn lose(&self) {
        self.fail(CallError::Gone);
    }

    fn fail(&self, error: CallError) {
        self.finish(Outcome::Lost(error));
    }

    fn finish(&self, outcome: Outcome) {
        drop(lock(&self.pending).take());
        let replies = lock(&self.replies).take();
        if let Some(replies) = replies {
            replies.finish(outcome);
        }
    }
}
