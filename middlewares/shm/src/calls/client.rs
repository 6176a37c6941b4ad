//! The calling end.

use std::sync::Arc;

use genom_middleware::describe::type_of_port;
use genom_middleware::{Address, CallError, Client, OpenError, Replies, Running, ServiceType};
use genom_types::Record;
use iceoryx2::port::client::{Client as RawClient, RequestSendError};
use iceoryx2::prelude::*;

use super::bell::Bell;
use super::call::Call;
use super::service::{CallService, FIRST_ROOM, service};
use crate::error::{BACKEND, failed};
use crate::inner::Inner;
use crate::raw::Ipc;

/// Memory for requests that is made beforehand.
const PREPARED: usize = 48;

struct ShmClient {
    port: RawClient<Ipc, [u8], (), [u8], ()>,
    service: CallService,
    at: Address,
    ty: ServiceType,
    bell: Arc<Bell>,
    inner: Arc<Inner>,
}

struct ShmRunning {
    call: Arc<Call>,
    /// The worker is needed until the request ends.
    _inner: Arc<Inner>,
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
        let call = Arc::new(Call::new(pending, replies, self.ty.output.clone(), &self.bell));
        let worker = self.inner.worker(&self.at).map_err(|error| broken(&error))?;
        worker.add_call(Arc::clone(&call));
        self.bell.ring();
        Ok(Box::new(ShmRunning { call, _inner: Arc::clone(&self.inner) }))
    }
}

impl Running for ShmRunning {
    fn cancel(&self) {
        self.call.cancel();
    }
}
