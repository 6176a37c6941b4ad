//! Connections: what feeds which in port.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use serde::Deserialize;
use serde_json::{Value, json};

use crate::daemon::Daemon;
use crate::rpc::error::RpcError;
use crate::rpc::input::Body;
use crate::rpc::{components, ports};
use crate::wiring::{self, ConnectError, ConnectRequest, Connection, policy};

/// Body of `POST /connections`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    #[serde(rename = "in")]
    inport: String,
    #[serde(rename = "out")]
    outport: String,
    #[serde(default)]
    policy: Option<String>,
    #[serde(default)]
    backend: Option<String>,
    #[serde(default)]
    wait: bool,
}

/// `GET /connections`
pub(crate) async fn list(State(daemon): State<Arc<Daemon>>) -> Json<Value> {
    let mut connections = Vec::new();
    for hosted in daemon.components.all() {
        for connection in hosted.wiring.connections() {
            connections.push(to_json(&connection));
        }
    }
    Json(json!({ "connections": connections }))
}

/// `POST /connections` with `{in, out, policy, backend, wait}`
pub(crate) async fn connect(
    State(daemon): State<Arc<Daemon>>,
    Body(wanted): Body<Wanted>,
) -> Result<(StatusCode, Json<Value>), RpcError> {
    let policy = match &wanted.policy {
        None => genom_middleware::Policy::Latest,
        Some(text) => {
            policy::parse(text).ok_or_else(|| RpcError::bad_input(policy::HELP).place("/policy"))?
        }
    };
    let request = ConnectRequest {
        inport: wanted.inport,
        outport: wanted.outport,
        policy,
        backend: wanted.backend,
        wait: wanted.wait,
    };
    let made =
        tokio::task::spawn_blocking(move || wiring::connect::connect(&daemon, &request)).await;
    match made {
        Ok(Ok(connection)) => Ok((StatusCode::CREATED, Json(to_json(&connection)))),
        Ok(Err(error)) => Err(refused(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

/// `DELETE /connections/{component}/{port}`
pub(crate) async fn disconnect(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port)): Path<(String, String)>,
) -> Result<Json<Value>, RpcError> {
    take_away(daemon, component, port, None).await
}

/// `DELETE /connections/{component}/{port}/{element}`
pub(crate) async fn disconnect_element(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port, element)): Path<(String, String, String)>,
) -> Result<Json<Value>, RpcError> {
    take_away(daemon, component, port, Some(element)).await
}

async fn take_away(
    daemon: Arc<Daemon>,
    component: String,
    port: String,
    element: Option<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = ports::find(&hosted, &port)?;
    let address = hosted.address(&port, element.as_deref());
    let work = tokio::task::spawn_blocking(move || {
        wiring::connect::disconnect(&daemon, &hosted, index, element.as_deref())
    });
    match work.await {
        Ok(true) => Ok(Json(json!({"disconnected": address.to_string()}))),
        Ok(false) => {
            Err(RpcError::conflict("not_connected", format!("{address} is not connected")))
        }
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn to_json(connection: &Connection) -> Value {
    json!({
        "in": connection.inport.to_string(),
        "out": connection.outport.to_string(),
        "backend": connection.backend,
        "policy": policy::text(connection.policy),
    })
}

fn refused(error: &ConnectError) -> RpcError {
    let message = error.to_string();
    let refused = match error {
        ConnectError::NoSuchInport { .. } => {
            RpcError::new(StatusCode::NOT_FOUND, "no_such_inport", message).place("/in")
        }
        ConnectError::NoSuchOutport { .. } => {
            RpcError::new(StatusCode::NOT_FOUND, "no_such_outport", message).place("/out")
        }
        ConnectError::Type { .. } => RpcError::conflict("type_mismatch", message).place("/out"),
        ConnectError::Backend(_) => RpcError::bad_input(message).place("/backend"),
        ConnectError::Failed(_) => {
            RpcError::new(StatusCode::BAD_GATEWAY, "middleware_failed", message)
        }
    };
    match error.help() {
        Some(help) => refused.help(help),
        None => refused,
    }
}
