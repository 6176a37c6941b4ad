//! Middlewares: what they can do, and what is visible on them.

use std::collections::BTreeMap;
use std::sync::Arc;

use axum::Json;
use axum::extract::State;
use genom_middleware::{Capabilities, Endpoint, Refused, Stranger};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use crate::daemon::Daemon;
use crate::registry::{self, Known};
use crate::rpc::error::RpcError;
use crate::rpc::input::Parameters;

/// `?visible=true`
#[derive(Debug, Default, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub(crate) struct ListParameters {
    /// Also list what is visible on the open ones.
    #[serde(default)]
    visible: bool,
}

/// The middlewares of the daemon.
#[derive(Debug, Serialize, ToSchema)]
pub(crate) struct Middlewares {
    /// The one of components that name none.
    default: String,
    middlewares: Vec<Described>,
}

/// A middleware.
#[derive(Debug, Serialize, ToSchema)]
#[schema(as = Middleware)]
pub(crate) struct Described {
    /// What `--backend` calls it.
    name: &'static str,
    /// Version of the library behind it.
    version: &'static str,
    /// What it can do; of an open one.
    #[schema(value_type = Option<Object>)]
    #[serde(skip_serializing_if = "Option::is_none")]
    capabilities: Option<Capabilities>,
    /// Where others meet it.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    meet: BTreeMap<&'static str, String>,
    /// What is visible on it.
    #[schema(value_type = Option<Vec<Object>>)]
    #[serde(skip_serializing_if = "Option::is_none")]
    endpoints: Option<Vec<Endpoint>>,
    /// Who is there besides and does not tell what it opens, as `{"kind": "session"}` or, of an
    /// out port of this daemon, `{"kind": "reader"}`.
    #[schema(value_type = Vec<Object>)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    strangers: Vec<Stranger>,
    /// What peers sent that would have harmed and was refused, as
    /// `{"why": "far ahead of what its writer sent", "count": 3, "peer": "10.0.0.7"}`.
    #[schema(value_type = Vec<Object>)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    refused: Vec<Refused>,
    /// Why nothing is visible.
    #[serde(skip_serializing_if = "Option::is_none")]
    problem: Option<String>,
}

/// List the middlewares, what they can do and what is visible on them.
#[utoipa::path(
    get,
    path = "/middlewares",
    tag = "middlewares",
    security(("token" = ["read"])),
    params(ListParameters),
    responses((status = 200, body = Middlewares))
)]
pub(crate) async fn list(
    State(daemon): State<Arc<Daemon>>,
    Parameters(parameters): Parameters<ListParameters>,
) -> Result<Json<Middlewares>, RpcError> {
    let visible = parameters.visible;
    // Discovery may have to ask other processes.
    tokio::task::spawn_blocking(move || Json(described(&daemon, visible)))
        .await
        .map_err(|error| RpcError::internal(error.to_string()))
}

fn described(daemon: &Daemon, visible: bool) -> Middlewares {
    let described = |known: &Known| {
        let open = daemon.backends.opened(known.name);
        let seen = open.as_ref().filter(|_| visible).map(|open| open.discover());
        let (endpoints, problem) = match seen {
            None => (None, None),
            Some(Ok(endpoints)) => (Some(endpoints), None),
            Some(Err(error)) => (None, Some(error.to_string())),
        };
        let looked = open.iter().filter(|_| visible);
        Described {
            strangers: looked.flat_map(|open| open.strangers()).collect(),
            name: known.name,
            version: known.version,
            capabilities: open.as_ref().map(|open| open.capabilities()),
            meet: open.iter().flat_map(|open| open.meeting_point()).collect(),
            refused: open.iter().flat_map(|open| open.refused()).collect(),
            endpoints,
            problem,
        }
    };
    Middlewares {
        default: daemon.settings.backend.clone(),
        middlewares: registry::known().iter().map(described).collect(),
    }
}
