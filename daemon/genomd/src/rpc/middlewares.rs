//! Middlewares: what they support, and what is visible on them.

use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use genom_doors::{Parameters, RpcError};
use genom_middleware as middleware;
use genom_protocol::{
    Capabilities, Endpoint, EndpointKind, Middleware, MiddlewareParameters, Middlewares, Refused,
    Stranger, Trouble,
};
use genom_registry::Known;
use genom_supervisor::Supervisor;

/// List the middlewares, what they support and what is visible on them.
#[utoipa::path(
    get,
    path = "/middlewares",
    tag = "middlewares",
    params(MiddlewareParameters),
    responses((status = 200, body = Middlewares))
)]
pub(crate) async fn list(
    State(supervisor): State<Arc<Supervisor>>,
    Parameters(parameters): Parameters<MiddlewareParameters>,
) -> Result<Json<Middlewares>, RpcError> {
    // Discovery may have to ask other processes, and blocks.
    tokio::task::spawn_blocking(move || Json(described(&supervisor, &parameters)))
        .await
        .map_err(|error| RpcError::internal(error.to_string()))
}

fn described(supervisor: &Supervisor, wanted: &MiddlewareParameters) -> Middlewares {
    let MiddlewareParameters { visible, trouble } = *wanted;
    let described = |known: &Known| {
        let open = supervisor.backends.opened(known.name);
        let seen = open.as_ref().filter(|_| visible).map(|open| open.discover());
        let (endpoints, problem) = match seen {
            None => (None, None),
            Some(Ok(endpoints)) => (Some(endpoints.into_iter().map(endpoint).collect()), None),
            Some(Err(error)) => (None, Some(error.to_string())),
        };
        let looked = open.iter().filter(|_| visible);
        let examined = open.iter().filter(|_| trouble);
        let meet = open.iter().flat_map(|open| open.meeting_point());
        Middleware {
            strangers: looked.flat_map(|open| open.strangers()).map(stranger).collect(),
            name: known.name.to_owned(),
            version: known.version.to_owned(),
            capabilities: open.as_ref().map(|open| capabilities(open.capabilities())),
            meet: meet.map(|(name, value)| (name.into_owned(), value)).collect(),
            refused: open.iter().flat_map(|open| open.refused()).map(refused).collect(),
            trouble: examined.flat_map(|open| open.trouble()).map(told).collect(),
            closed: supervisor.backends.closed(known.name),
            endpoints,
            problem,
        }
    };
    Middlewares {
        default: supervisor.settings.backend.clone(),
        middlewares: genom_registry::known().iter().map(described).collect(),
    }
}

fn capabilities(of: middleware::Capabilities) -> Capabilities {
    let middleware::Capabilities {
        variable_size,
        zero_copy,
        cross_process,
        cross_host,
        services,
        native_services,
    } = of;
    Capabilities { variable_size, zero_copy, cross_process, cross_host, services, native_services }
}

fn endpoint(of: middleware::Endpoint) -> Endpoint {
    let kind = match of.kind {
        middleware::EndpointKind::Publisher => EndpointKind::Publisher,
        middleware::EndpointKind::Subscription => EndpointKind::Subscription,
        middleware::EndpointKind::Service => EndpointKind::Service,
    };
    Endpoint { kind, address: of.address, ty: of.ty }
}

fn stranger(of: middleware::Stranger) -> Stranger {
    match of {
        middleware::Stranger::Reader { address } => Stranger::Reader { address },
        middleware::Stranger::Session { name, role } => {
            Stranger::Session { name, role: role.into_owned() }
        }
    }
}

fn told(of: middleware::Obstacle) -> Trouble {
    Trouble { what: of.what, fix: of.fix }
}

fn refused(of: middleware::Refused) -> Refused {
    Refused { why: of.why.into_owned(), count: of.count, peer: of.peer }
}
