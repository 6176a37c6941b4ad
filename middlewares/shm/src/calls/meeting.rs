//! The iceoryx2 service through which a daemon receives requests.

use genom_middleware::{Address, OpenError};
use iceoryx2::prelude::*;
use iceoryx2::service::builder::request_response::{
    RequestResponseCreateError as Create, RequestResponseOpenError as Open,
};
use iceoryx2::service::port_factory::request_response::PortFactory as CallFactory;

use crate::attain::{Attempt, attain};
use crate::error::failed;
use crate::ground::Ground;
use crate::raw::Ipc;

/// A request-response service whose messages are byte slices.
pub(super) type CallService = CallFactory<Ipc, [u8], (), [u8], ()>;

/// Prefix of the names of these services; the id of the daemon's node follows.
const PREFIX: &str = "genom.calls/";

/// Requests from one daemon to another that may be in progress at a time.
pub(super) const REQUESTS: usize = 128;
/// Responses to one request that may wait for the caller's thread. Beyond that the oldest are lost,
/// never the last.
const RESPONSES: usize = 32;
/// Number of daemons that may call one daemon.
const CALLERS: usize = 64;
/// Initial size of messages in bytes; doubles when needed.
pub(super) const FIRST_ROOM: usize = 512;

/// Name of the service of the daemon whose node is `owner`.
fn name(owner: u128, at: &Address) -> Result<ServiceName, OpenError> {
    Ground::service_name(&format!("{PREFIX}{owner:032x}"), at)
}

/// Creates the service of this daemon.
pub(super) fn create(ground: &Ground, at: &Address) -> Result<CallService, OpenError> {
    let name = name(ground.node.id().value(), at)?;
    let create = || {
        let create = ground
            .node
            .service_builder(&name)
            .request_response::<[u8], [u8]>()
            .max_servers(1)
            .max_clients(CALLERS)
            .max_nodes(CALLERS + 1)
            .max_active_requests_per_client(REQUESTS)
            .max_response_buffer_size(RESPONSES)
            .enable_safe_overflow_for_responses(true)
            .create();
        match create {
            Ok(service) => Ok(Attempt::Done(service)),
            Err(
                error @ (Create::AlreadyExists
                | Create::IsBeingCreatedByAnotherInstance
                | Create::HangsInCreation),
            ) => Ok(Attempt::Busy(error.to_string())),
            Err(error) => Err(failed(at, &error.to_string())),
        }
    };
    attain(ground.keeping(), at, || Ok(Attempt::Absent), create)
}

/// Opens the service of another daemon; `None` if it is gone.
pub(super) fn open(
    ground: &Ground,
    owner: u128,
    at: &Address,
) -> Result<Option<CallService>, OpenError> {
    let name = name(owner, at)?;
    let builder = || ground.node.service_builder(&name).request_response::<[u8], [u8]>();
    let open = || match builder().open() {
        Ok(service) => Ok(Attempt::Done(Some(service))),
        Err(Open::DoesNotExist) => Ok(Attempt::Done(None)),
        Err(
            error @ (Open::IsMarkedForDestruction
            | Open::HangsInCreation
            | Open::ServiceInCorruptedState),
        ) => Ok(Attempt::Broken(error.to_string())),
        Err(error) => Err(failed(at, &error.to_string())),
    };
    attain(ground.keeping(), at, open, || Ok(Attempt::Absent))
}
