//! The calling end.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use genom_middleware::describe::type_of_port;
use genom_middleware::{
    Address, CallError, Client, OpenError, Outcome, Replies, Running, ServiceType,
};
use genom_types::{DataType, Record};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::{Client as RawClient, RequestSendError};
use iceoryx2::prelude::*;

use super::frame::{self, Response};
use super::worker::Bell;
use super::{CallService, FIRST_ROOM, service};
use crate::backend::{BACKEND, Inner, failed};
use crate::raw::Ipc;

/// Memory for requests that is made beforehand.
const PREPARED: usize = 48;

type Pending = PendingResponse<Ipc, [u8], (), [u8], ()>;

struct ShmClient {
    port: RawClient<Ipc, [u8], (), [u8], ()>,
    service: CallService,
    at: Address,
    ty: ServiceType,
    bell: Arc<Bell>,
    inner: Arc<Inner>,
}

/// One request under way, as the worker sees it.
pub(super) struct Call {
    /// Dropped when the request ends.
    pending: Mutex<Option<Pending>>,
    /// Taken when the request ends.
    replies: Mutex<Option<Box<dyn Replies>>>,
    output: DataType,
    bell: Arc<Bell>,
}

struct ShmRunning {
    call: Arc<Call>,
    /// The worker is needed until the request ends.
    _inner: Arc<Inner>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

fn broken(why: &impl ToString) -> CallError {
    CallError::Failed { backend: BACKEND.to_owned(), why: why.to_string() }
}

pub(crate) fn open(
    inner: &Arc<Inner>,
    at: &Address,
    ty: &ServiceType,
) -> Result<impl Client + 'static, OpenError> {
    let bell = Arc::clone(inner.worker(at)?.bell());
    let service = service(&inner.ground, at, ty)?;
    let port = service
        .client_builder()
        .initial_max_slice_len(FIRST_ROOM)
        .allocation_strategy(AllocationStrategy::PowerOfTwo)
        .override_request_preallocation(|worst| worst.min(PREPARED))
        .create()
        .map_err(|error| failed(at, &error.to_string()))?;
    let inner = Arc::clone(inner);
    Ok(ShmClient { port, service, at: at.clone(), ty: ty.clone(), bell, inner })
}

impl Client for ShmClient {
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError> {
        if !input.ty().same_as(&self.ty.input) {
            return Err(CallError::TypeMismatch {
                address: self.at.clone(),
                ours: type_of_port(input.ty()),
                theirs: type_of_port(&self.ty.input),
            });
        }
        if self.service.dynamic_config().number_of_servers() == 0 {
            return Err(CallError::Nobody { address: self.at.clone() });
        }
        let mut message = Vec::new();
        input
            .encode_message(&mut message)
            .map_err(|error| CallError::Serialization(error.to_string()))?;
        let loan = self.port.loan_slice_uninit(message.len()).map_err(|error| broken(&error))?;
        let pending = loan.write_from_slice(&message).send().map_err(|error| match error {
            RequestSendError::ExceedsMaxActiveRequests => {
                broken(&"too many requests are under way")
            }
            other => broken(&other),
        })?;
        let call = Arc::new(Call {
            pending: Mutex::new(Some(pending)),
            replies: Mutex::new(Some(replies)),
            output: self.ty.output.clone(),
            bell: Arc::clone(&self.bell),
        });
        let worker = self.inner.worker(&self.at).map_err(|error| broken(&error))?;
        worker.add_call(Arc::clone(&call));
        self.bell.ring();
        Ok(Box::new(ShmRunning { call, _inner: Arc::clone(&self.inner) }))
    }
}

impl Call {
    /// Hands on what came back; whether the request has ended.
    pub(super) fn work(&self) -> bool {
        loop {
            // Asked before the last look: what was sent before the end is there.
            let (response, over) = match &*lock(&self.pending) {
                Some(pending) => {
                    let over = !pending.is_connected();
                    match pending.receive() {
                        Ok(Some(response)) => {
                            (Some(frame::read(response.payload(), &self.output)), over)
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

    /// The server is gone, or this side.
    pub(super) fn lose(&self) {
        self.finish(Outcome::Lost(CallError::Gone));
    }

    fn finish(&self, outcome: Outcome) {
        drop(lock(&self.pending).take());
        let replies = lock(&self.replies).take();
        if let Some(replies) = replies {
            replies.finish(outcome);
        }
    }
}

impl Running for ShmRunning {
    fn cancel(&self) {
        if let Some(pending) = &*lock(&self.call.pending) {
            pending.set_disconnect_hint();
        }
        self.call.bell.ring();
    }
}
