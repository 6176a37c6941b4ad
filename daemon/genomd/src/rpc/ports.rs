//! Ports: connections, values, counters.

use std::sync::Arc;

use axum::Json;
use axum::extract::{Path, State};
use genom_cells::Cells;
use genom_description::model;
use genom_doors::{Body, Parameters, RpcError};
use genom_ports::PortKey;
use genom_protocol::{
    Code, Port, PortDirection, PortParameters, PortTraffic, PortType, Ports, Published,
    ValueParameters,
};
use genom_supervisor::Supervisor;
use genom_supervisor::components::Hosted;
use genom_supervisor::connections::feed::FeedError;
use genom_types::Record;
pub(super) use genom_views::{find_port as find, key};
use genom_views::{layout, not_published};
use serde_json::Value;

use crate::rpc::components;

/// List the ports of all components.
#[utoipa::path(
    get,
    path = "/ports",
    tag = "ports",
    params(PortParameters),
    responses((status = 200, body = Ports))
)]
pub(crate) async fn all(
    State(supervisor): State<Arc<Supervisor>>,
    State(cells): State<Arc<Cells>>,
    Parameters(parameters): Parameters<PortParameters>,
) -> Json<Ports> {
    let components = supervisor.components.all();
    let described = |hosted: &Arc<Hosted>| described(hosted, &parameters);
    let mut all = Ports { ports: components.iter().flat_map(described).collect() };
    drop(components);
    cells.join_ports(&mut all, &parameters).await;
    Json(all)
}

/// List the ports of a component.
#[utoipa::path(
    get,
    path = "/components/{component}/ports",
    tag = "ports",
    params(PortParameters),
    responses((status = 200, body = Ports), (status = 404))
)]
pub(crate) async fn of_component(
    State(supervisor): State<Arc<Supervisor>>,
    Path(component): Path<String>,
    Parameters(parameters): Parameters<PortParameters>,
) -> Result<Json<Ports>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    Ok(Json(Ports { ports: described(&hosted, &parameters) }))
}

/// Describe a port, with its last value.
#[utoipa::path(
    get,
    path = "/components/{component}/ports/{port}",
    tag = "ports",
    params(ValueParameters),
    responses((status = 200, body = Port), (status = 404), (status = 422))
)]
pub(crate) async fn value(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<ValueParameters>,
) -> Result<Json<Port>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let key = key(&hosted, &port, parameters.element)?;
    Ok(Json(Port { value: hosted.port_value(&key), ..one(&hosted, &key) }))
}

/// Publish a value to an in port.
///
/// The first such request connects the port to the values published here. Members that are left out
/// keep their last values. The schema of the value is that of the port.
#[utoipa::path(
    post,
    path = "/components/{component}/ports/{port}",
    tag = "ports",
    params(ValueParameters),
    request_body = Value,
    responses(
        (status = 200, body = Published), (status = 404), (status = 409), (status = 422),
        (status = 502), (status = 503)
    )
)]
pub(crate) async fn publish(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<ValueParameters>,
    Body(value): Body<Value>,
) -> Result<Json<Published>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let key = key(&hosted, &port, parameters.element)?;
    let address = hosted.port_address(&key).to_string();
    let work = tokio::task::spawn_blocking(move || {
        let fill = |record: &mut Record| Ok::<_, FeedError>(record.merge_json(&value)?);
        supervisor.connections.feed(&hosted, &key, fill, Record::to_json)
    });
    match work.await {
        Ok(Ok(value)) => Ok(Json(Published { address, value })),
        Ok(Err(error)) => Err(not_published(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

/// Get the type of a port, with its memory layout.
///
/// For programs that read or write the port on its middleware directly.
#[utoipa::path(
    get,
    path = "/components/{component}/ports/{port}/type",
    tag = "ports",
    responses((status = 200, body = PortType), (status = 404))
)]
pub(crate) async fn layout(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, port)): Path<(String, String)>,
) -> Result<Json<PortType>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let index = find(&hosted, &port)?;
    match hosted.port_type(index) {
        Some(ty) => Ok(Json(layout::of(ty))),
        None => Err(RpcError::internal(format!("{component}/{port} has no type"))),
    }
}

/// Get counters of a port; differences between two readings give rates, as in `genomctl hz` and
/// `genomctl bw`.
#[utoipa::path(
    get,
    path = "/components/{component}/ports/{port}/traffic",
    tag = "ports",
    params(ValueParameters),
    responses((status = 200, body = PortTraffic), (status = 404), (status = 409), (status = 422))
)]
pub(crate) async fn traffic(
    State(supervisor): State<Arc<Supervisor>>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<ValueParameters>,
) -> Result<Json<PortTraffic>, RpcError> {
    let hosted = components::find(&supervisor.components, &component)?;
    let key = key(&hosted, &port, parameters.element)?;
    let address = hosted.port_address(&key);
    let Some(gauge) = hosted.ties.gauge(&key) else {
        let message = format!("nothing passes through {address}: it is not connected");
        return Err(RpcError::conflict(Code::NotConnected, message)
            .help(format!("`genomctl connect {address} COMPONENT/PORT`")));
    };
    Ok(Json(PortTraffic { traffic: gauge.traffic(), address: address.to_string() }))
}

fn described(hosted: &Hosted, parameters: &PortParameters) -> Vec<Port> {
    let values = parameters.values.unwrap_or(true);
    let one = |key: &PortKey| {
        let value = values.then(|| hosted.port_value(key)).flatten();
        Port { value, ..one(hosted, key) }
    };
    let mut out = Vec::new();
    for index in hosted.model().ports.places() {
        let elements = hosted.elements(index);
        if elements.is_empty() {
            out.push(one(&PortKey::new(index, None)));
        }
        out.extend(elements.iter().map(one));
    }
    out
}

/// A port without its value.
fn one(hosted: &Hosted, key: &PortKey) -> Port {
    let port = &hosted.model().ports[key.port];
    let connection = hosted.ties.connection(key);
    Port {
        address: hosted.port_address(key).to_string(),
        name: port.name.clone(),
        direction: direction(port.direction),
        multiple: port.multiple,
        ty: hosted.specification().types.spelling(port.ty),
        digest: hosted.port_type(key.port).map(|ty| ty.digest().to_owned()),
        doc: port.doc.clone(),
        connected: connection.as_ref().map(|connection| connection.outport.to_string()),
        over: connection.map(|connection| connection.backend),
        backend: hosted.backends_of(key),
        traffic: hosted.ties.gauge(key).map(|gauge| gauge.counts()),
        value: None,
    }
}

fn direction(of: model::PortDirection) -> PortDirection {
    match of {
        model::PortDirection::In => PortDirection::In,
        model::PortDirection::Out => PortDirection::Out,
    }
}
