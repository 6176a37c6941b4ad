//! Connections: list, make, remove.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use genom_cells::Cells;
use genom_configuration::terms;
use genom_doors::{Body, RpcError};
use genom_protocol::{
    Code, Connection as Made, ConnectionKind, ConnectionRequest, Connections, Disconnected,
    NoPolicy, component_of,
};
use genom_supervisor::Supervisor;
use genom_supervisor::connections::{self, ConnectError, Patience};
use genom_supervisor::ties::Connection;
use genom_views::not_connected;

use crate::rpc;
use crate::rpc::{components, ports};

/// List the connections.
#[utoipa::path(
    get,
    path = "/connections",
    tag = "wiring",
    responses((status = 200, body = Connections))
)]
pub(crate) async fn list(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
) -> Json<Connections> {
    let connections = supervisor.connections.all().iter().map(told).collect();
    let mut all = Connections { connections };
    cells.join_connections(&mut all).await;
    Json(all)
}

/// Connect an in port to an out port, or a remote to a service.
///
/// A policy must not be given for a remote. The other side may belong to another daemon. An out port
/// of this one that is not on the middleware `over` is opened there, and closed again with the last
/// connection over it.
#[utoipa::path(
    post,
    path = "/connections",
    tag = "wiring",
    request_body = ConnectionRequest,
    responses(
        (status = 201, body = genom_protocol::Connection), (status = 404), (status = 409), (status = 422), (status = 502),
        (status = 503)
    )
)]
pub(crate) async fn connect(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Body(wanted): Body<ConnectionRequest>,
) -> Result<(StatusCode, Json<Made>), RpcError> {
    // Whoever asked may go away meanwhile: it is then made as a whole all the same.
    let connecting = tokio::spawn(make(supervisor, cells, wanted));
    connecting.await.unwrap_or_else(|error| Err(RpcError::internal(error.to_string())))
}

async fn make(
    supervisor: Arc<Supervisor>,
    cells: Arc<Cells>,
    wanted: ConnectionRequest,
) -> Result<(StatusCode, Json<Made>), RpcError> {
    let reader = component_of(&wanted.inport);
    if let Some(cell) = cells.of(reader) {
        let made = cells.connect(&supervisor, &cell, &wanted).await;
        return made.map(|made| (StatusCode::CREATED, Json(made))).map_err(rpc::cells::refused);
    }
    let read = |text: &String| {
        let read = text.parse().map(terms::policy);
        read.map_err(|error: NoPolicy| RpcError::bad_input(error.to_string()).place("/policy"))
    };
    let wanted = connections::Wanted {
        policy: wanted.policy.as_ref().map(read).transpose()?,
        inport: wanted.inport,
        kind: None,
        outport: wanted.outport,
        over: wanted.over,
        wait: wanted.wait,
        patience: Patience::Full,
    };
    let (worker, asked) = (Arc::clone(&supervisor), wanted.clone());
    let making = async {
        let work = move || worker.connections.connect(&asked);
        match tokio::task::spawn_blocking(work).await {
            Ok(Ok(connection)) => Ok((StatusCode::CREATED, Json(told(&connection)))),
            Ok(Err(error)) => Err(not_connected(&error)),
            Err(error) => Err(RpcError::internal(error.to_string())),
        }
    };
    // The out port may be in a cell.
    let ends = (wanted.inport.as_str(), wanted.outport.as_str(), wanted.over.as_deref());
    cells.connect_over(&supervisor, ends, making).await.map_err(rpc::cells::refused)?
}

/// Disconnect an in port or a remote.
#[utoipa::path(
    delete,
    path = "/connections/{component}/{port}",
    tag = "wiring",
    responses(
        (status = 200, body = Disconnected), (status = 404), (status = 409), (status = 503)
    )
)]
pub(crate) async fn disconnect(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Path((component, port)): Path<(String, String)>,
) -> Result<Json<Disconnected>, RpcError> {
    take_away(supervisor, cells, component, port, None).await
}

/// Disconnect an element of a multiple in port.
#[utoipa::path(
    delete,
    path = "/connections/{component}/{port}/{element}",
    tag = "wiring",
    responses(
        (status = 200, body = Disconnected), (status = 404), (status = 409), (status = 503)
    )
)]
pub(crate) async fn disconnect_element(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Path((component, port, element)): Path<(String, String, String)>,
) -> Result<Json<Disconnected>, RpcError> {
    take_away(supervisor, cells, component, port, Some(element)).await
}

async fn take_away(
    supervisor: Arc<Supervisor>,
    cells: Arc<Cells>,
    component: String,
    port: String,
    element: Option<String>,
) -> Result<Json<Disconnected>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let remotes = &hosted.model().remotes;
    if element.is_some() || !remotes.iter().any(|remote| remote.name == port) {
        ports::find(&hosted, &port)?;
    }
    let address = hosted.address(&port, element.as_deref()).to_string();
    let (worker, inport) = (Arc::clone(&supervisor), address.clone());
    let work = tokio::task::spawn_blocking(move || worker.connections.disconnect(&inport));
    match work.await {
        Ok(Ok(true)) => {
            cells.disconnected(&supervisor, &address).await;
            Ok(Json(Disconnected { disconnected: address }))
        }
        // Nor can anything else of that name be connected.
        Ok(Ok(false) | Err(ConnectError::NoSuchInport { .. })) => {
            Err(RpcError::conflict(Code::NotConnected, format!("{address} is not connected")))
        }
        Ok(Err(error)) => Err(not_connected(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn told(connection: &Connection) -> Made {
    Made {
        kind: match connection {
            Connection::Port(_) => ConnectionKind::Port,
            Connection::Service(_) => ConnectionKind::Service,
        },
        inport: connection.inport().to_string(),
        outport: connection.outport().to_string(),
        backend: connection.backend().map(str::to_owned),
        fixed: connection.fixed(),
        policy: connection.policy().map(|policy| terms::told_policy(policy).to_string()),
    }
}
