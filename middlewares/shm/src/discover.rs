//! Discovery on shared memory: ports and services of this daemon and of others.

use genom_middleware::{Address, DiscoverError, Endpoint, EndpointKind};
use iceoryx2::prelude::*;
use iceoryx2::service::static_config::StaticConfig;
use iceoryx2::service::static_config::messaging_pattern::MessagingPattern as Pattern;

use crate::attributes::{TYPE_KEY, attribute};
use crate::catalog::{self, Kind};
use crate::error::BACKEND;
use crate::ground::Ground;
use crate::queue;
use crate::raw::{self, Ipc};

/// Every end of every publish-subscribe service, and every service that is served.
pub(crate) fn list(node: &Node<Ipc>) -> Result<Vec<Endpoint>, DiscoverError> {
    let mut services = Vec::new();
    <Ipc as Service>::list(node.config(), |service| {
        services.push(service.static_details);
        CallbackProgression::Continue
    })
    .map_err(|error| DiscoverError { backend: BACKEND.to_owned(), why: error.to_string() })?;
    let mut seen = Vec::new();
    for service in services {
        match service.messaging_pattern() {
            Pattern::PublishSubscribe(_) if !service.name().as_str().starts_with(queue::PREFIX) => {
                ends(node, &service, &mut seen);
            }
            _ => {}
        }
    }
    catalog::listed(node, &mut seen);
    Ok(seen)
}

/// The endpoints at one address; opens at most one service of iceoryx2 for it, and reads only what
/// is new in catalogs.
pub(crate) fn at(ground: &Ground, at: &Address) -> Vec<Endpoint> {
    let (node, mut seen) = (&ground.node, Vec::new());
    let address = at.to_string();
    let Ok(name) = ServiceName::new(&address) else { return seen };
    let pattern = MessagingPattern::PublishSubscribe;
    if let Ok(Some(service)) = <Ipc as Service>::details(&name, node.config(), pattern) {
        ends(node, &service.static_details, &mut seen);
    }
    let mut offers = ground.offered(Kind::Service, at);
    if !seen.iter().any(|end| end.kind == EndpointKind::Publisher) {
        offers.extend(ground.offered(Kind::Writer, at));
    }
    seen.extend(offers);
    seen
}

/// Adds the ends of one service; none if it has disappeared.
fn ends(node: &Node<Ipc>, service: &StaticConfig, seen: &mut Vec<Endpoint>) {
    let details = service.publish_subscribe().message_type_details();
    let open = raw::open_to_look(node, service.name(), &details.payload, &details.user_header);
    let Ok(open) = open else { return };
    let config = open.dynamic_config();
    let ty = attribute(service.attributes(), TYPE_KEY)
        .unwrap_or_else(|| details.payload.type_name().to_string());
    for (kind, count) in [
        (EndpointKind::Publisher, config.number_of_publishers()),
        (EndpointKind::Subscription, config.number_of_subscribers()),
    ] {
        let address = service.name().to_string();
        seen.extend((0..count).map(|_| Endpoint {
            kind,
            address: address.clone(),
            ty: ty.clone(),
        }));
    }
}
