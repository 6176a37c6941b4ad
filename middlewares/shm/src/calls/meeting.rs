//! Where a daemon takes requests: the service of iceoryx2 that its callers and it meet at.

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

/// A service of requests and responses as byte slices.
pub(super) type CallService = CallFactory<Ipc, [u8], (), [u8], ()>;

/// Start of the names of these services; the node of the daemon comes after it.
const PREFIX: &str = "genom.calls/";

/// Requests of one daemon to another that are under way at a time.
pub(super) const REQUESTS: usize = 128;
/// Responses to one request that wait for the caller's thread; more lose the oldest, never the last.
const RESPONSES: usize = 32;
/// Daemons that call one daemon.
const CALLERS: usize = 64;
/// First room for messages; it doubles as needed.
pub(super) const FIRST_ROOM: usize = 512;

/// The name of the service of a daemon, by its node.
fn name(owner: u128, at: &Address) -> Result<ServiceName, OpenError> {
    Ground::service_name(&format!("{PREFIX}{owner:032x}"), at)
}

/// Makes that of this daemon.
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

/// Opens that of a daemon; `None` when it is gone.
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
