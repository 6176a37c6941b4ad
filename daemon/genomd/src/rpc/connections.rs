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
use crate::wiring::remote::{self, RemoteError, RemoteRequest};
use crate::wiring::{self, ConnectError, ConnectRequest, Connection, RemoteConnection, policy};

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
        connections.extend(hosted.wiring.connections().iter().map(to_json));
        connections.extend(hosted.wiring.remotes().iter().map(remote_json));
    }
    Json(json!({ "connections": connections }))
}

/// `POST /connections` with `{in, out, policy, backend, wait}`
///
/// `in` is an in port, or a remote; then `out` is a service, and there is no policy.
pub(crate) async fn connect(
    State(daemon): State<Arc<Daemon>>,
    Body(wanted): Body<Wanted>,
) -> Result<(StatusCode, Json<Value>), RpcError> {
    if remote::named(&daemon, &wanted.inport).is_some() {
        return connect_remote(daemon, wanted).await;
    }
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
        patient: true,
    };
    let work = move || {
        let made = wiring::connect::connect(&daemon, &request)?;
        daemon.declared.forget(&request.inport);
        Ok(made)
    };
    let made = tokio::task::spawn_blocking(work).await;
    match made {
        Ok(Ok(connection)) => Ok((StatusCode::CREATED, Json(to_json(&connection)))),
        Ok(Err(error)) => Err(refused(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

async fn connect_remote(
    daemon: Arc<Daemon>,
    wanted: Wanted,
) -> Result<(StatusCode, Json<Value>), RpcError> {
    let Wanted { inport: remote, outport: service, policy, backend, wait } = wanted;
    if policy.is_some() {
        let message = format!("{remote} is a remote: it takes a service, and no policy");
        return Err(RpcError::bad_input(message).place("/policy"));
    }
    let request = RemoteRequest { remote, service, backend, wait };
    let work = move || remote::connect(&daemon, &request);
    match tokio::task::spawn_blocking(work).await {
        Ok(Ok(connection)) => Ok((StatusCode::CREATED, Json(remote_json(&connection)))),
        Ok(Err(error)) => {
            let (status, code, place) = match &error {
                RemoteError::NoSuchRemote { .. } => {
                    (StatusCode::NOT_FOUND, "no_such_remote", "/in")
                }
                RemoteError::NoSuchService { .. } => {
                    (StatusCode::NOT_FOUND, "no_such_service", "/out")
                }
                RemoteError::Differs { .. } => (StatusCode::CONFLICT, "type_mismatch", "/out"),
                RemoteError::Backend(error) => {
                    return Err(RpcError::bad_input(error.to_string()).place("/backend"));
                }
                RemoteError::Failed(_) => (StatusCode::BAD_GATEWAY, "middleware_failed", "/out"),
            };
            Err(RpcError::new(status, code, error.to_string()).place(place))
        }
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
    let address = hosted.address(&port, element.as_deref());
    let work = if let Some((caller, index)) = remote::named(&daemon, &address.to_string()) {
        tokio::task::spawn_blocking(move || remote::disconnect(&daemon, &caller, index))
    } else {
        let index = ports::find(&hosted, &port)?;
        tokio::task::spawn_blocking(move || {
            daemon.declared.forget(&hosted.address(&port, element.as_deref()).to_string());
            wiring::connect::disconnect(&daemon, &hosted, index, element.as_deref())
        })
    };
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
        "kind": "port",
        "in": connection.inport.to_string(),
        "out": connection.outport.to_string(),
        "backend": connection.backend,
        "policy": policy::text(connection.policy),
    })
}

fn remote_json(connection: &RemoteConnection) -> Value {
    json!({
        "kind": "service",
        "in": connection.remote.to_string(),
        "out": connection.service.to_string(),
        "backend": connection.backend,
    })
}

fn refused(error: &ConnectError) -> RpcError {
    let message = error.to_string();
    let refused = match error {
        // The code says it already, which codels see in the message alone.
        ConnectError::NoSuchInport { message, .. } => {
            RpcError::new(StatusCode::NOT_FOUND, "no_such_inport", message).place("/in")
        }
        ConnectError::NoSuchOutport { message, .. } => {
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
