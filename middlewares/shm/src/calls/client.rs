//! The calling end of one service.

use std::sync::Arc;

use genom_middleware::describe::{type_of_port, types_of_service};
use genom_middleware::{Address, CallError, Client, OpenError, Replies, Running, ServiceType};
use genom_types::Record;
use iceoryx2::port::client::RequestSendError;

use super::call::Call;
use super::desk::Desk;
use super::frame;
use super::meeting::REQUESTS;
use super::request::digests;
use crate::catalog::Kind;
use crate::error::BACKEND;

struct ShmClient {
    at: Address,
    ty: ServiceType,
    /// The bytes that precede the input in every request.
    start: Vec<u8>,
    desk: Arc<Desk>,
}

struct ShmRunning {
    call: Arc<Call>,
    /// Keeps the worker thread until the request ends.
    _desk: Arc<Desk>,
}

fn broken(why: &impl ToString) -> CallError {
    CallError::Failed { backend: BACKEND.to_owned(), why: why.to_string() }
}

pub(crate) fn open(
    desk: &Arc<Desk>,
    at: &Address,
    ty: &ServiceType,
) -> Result<impl Client + 'static, OpenError> {
    let digests = digests(ty);
    for (_, offer) in desk.inner.ground.find(Kind::Service, at) {
        if offer.digests != digests {
            return Err(OpenError::TypeMismatch {
                address: at.clone(),
                ours: types_of_service(ty),
                theirs: format!("{}, digests of {}", offer.spelling, offer.digests),
            });
        }
    }
    let start = frame::request(&at.to_string(), &digests);
    Ok(ShmClient { at: at.clone(), ty: ty.clone(), start, desk: Arc::clone(desk) })
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
        let worker = self.desk.worker(&self.at).map_err(|error| broken(&error))?;
        let way = worker.callers.way(&self.desk.inner.ground, &self.at).map_err(|e| broken(&e))?;
        let way = way.ok_or_else(|| CallError::Nobody { address: self.at.clone() })?;
        let mut message = Vec::new();
        input
            .encode_message(&mut message)
            .map_err(|error| CallError::Serialization(error.to_string()))?;
        let message = [self.start.as_slice(), &message].concat();
        let loan = way.client.loan_slice_uninit(message.len()).map_err(|error| broken(&error))?;
        let pending = loan.write_from_slice(&message).send().map_err(|error| match error {
            RequestSendError::ExceedsMaxActiveRequests => broken(&format!(
                "{REQUESTS} requests of this daemon are under way at the one that serves {}, and \
                 there may be no more: wait until one ends",
                self.at
            )),
            other => broken(&other),
        })?;
        let call = Arc::new(Call::new(pending, replies, &self.at, &self.ty, worker.bell()));
        worker.add_call(Arc::clone(&call));
        worker.bell().ring();
        Ok(Box::new(ShmRunning { call, _desk: Arc::clone(&self.desk) }))
    }
}

impl Running for ShmRunning {
    fn cancel(&self) {
        self.call.cancel();
    }
}
