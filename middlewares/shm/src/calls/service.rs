//! Opens the service that callers and a server meet at.

use genom_middleware::describe::types_of_service;
use genom_middleware::{Address, OpenError, ServiceKind, ServiceType};
use iceoryx2::prelude::*;
use iceoryx2::service::builder::request_response::{
    RequestResponseCreateError as Create, RequestResponseOpenError as Open,
};
use iceoryx2::service::port_factory::request_response::PortFactory as CallFactory;

use crate::attain::{Attempt, attain};
use crate::attributes::{attribute, attributes};
use crate::error::failed;
use crate::ground::Ground;
use crate::raw::Ipc;

/// A service of requests and responses as byte slices.
pub(super) type CallService = CallFactory<Ipc, [u8], (), [u8], ()>;

/// Requests of one client under way at a time.
const REQUESTS: usize = 32;
/// Responses that wait for the caller's thread; more lose the oldest, never the last.
const RESPONSES: usize = 64;
/// Callers of one service.
const CALLERS: usize = 32;
/// First room for messages; it doubles as needed.
pub(super) const FIRST_ROOM: usize = 512;

/// Attribute that says what a service takes and gives, for people.
pub(crate) const SERVICE_KEY: &str = "genom.service";
/// Attribute with kind and digests, by which callers and servers agree.
const DIGESTS_KEY: &str = "genom.digests";

fn own_attributes(service: &ServiceType) -> [(&'static str, String); 2] {
    let kind = match service.kind {
        ServiceKind::Attribute => "attribute",
        ServiceKind::Function => "function",
        ServiceKind::Activity => "activity",
    };
    let text = format!("{} -> {}", service.input.name(), service.output.name());
    // The spelling is for people; what matters fits.
    let spelling: String = text.chars().take(120).collect();
    let digests = format!("{kind} {}", service.digest());
    [(SERVICE_KEY, format!("{kind} {spelling}")), (DIGESTS_KEY, digests)]
}

/// Opens the service, or creates it.
pub(super) fn service(
    ground: &Ground,
    at: &Address,
    ty: &ServiceType,
) -> Result<CallService, OpenError> {
    let name = Ground::service_name(&at.to_string(), at)?;
    let ours = own_attributes(ty);
    let builder = || ground.node.service_builder(&name).request_response::<[u8], [u8]>();
    let open = || match builder().open() {
        Ok(service) => agree(at, ty, &ours, service).map(Attempt::Done),
        Err(Open::DoesNotExist) => Ok(Attempt::Absent),
        Err(
            error @ (Open::IsMarkedForDestruction
            | Open::HangsInCreation
            | Open::ServiceInCorruptedState),
        ) => Ok(Attempt::Broken(error.to_string())),
        Err(error) => Err(failed(at, &error.to_string())),
    };
    let create = || {
        let [(service, spelling), (digests, both)] = &ours;
        let create = builder()
            .max_servers(1)
            .max_clients(CALLERS)
            .max_nodes(CALLERS + 1)
            .max_active_requests_per_client(REQUESTS)
            .max_response_buffer_size(RESPONSES)
            .enable_safe_overflow_for_responses(true)
            .create_with_attributes(&attributes([(service, spelling), (digests, both)]));
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
    attain(&ground.node, ground.options.keep_free, at, open, create)
}

fn agree(
    at: &Address,
    ty: &ServiceType,
    ours: &[(&'static str, String); 2],
    service: CallService,
) -> Result<CallService, OpenError> {
    let theirs = [SERVICE_KEY, DIGESTS_KEY]
        .map(|key| attribute(service.attributes(), key).unwrap_or_default());
    let [_, (_, digests)] = ours;
    if theirs.last() == Some(digests) {
        return Ok(service);
    }
    Err(OpenError::TypeMismatch {
        address: at.clone(),
        ours: types_of_service(ty),
        theirs: theirs.join(", digests of "),
    })
}
