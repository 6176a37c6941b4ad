//! Ports: what they are connected to, their values, and values as they come.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::response::sse::{Event, Sse};
use genom_middleware::OpenError;
use serde::Deserialize;
use serde_json::{Map, Value, json};
use tokio::time::{MissedTickBehavior, interval};
use tokio_stream::Stream;

use crate::daemon::Daemon;
use crate::hosting::{self, Hosted};
use crate::rpc::components;
use crate::rpc::error::RpcError;
use crate::rpc::input::{Body, Parameters};
use crate::rpc::stream::{self, Writer};
use crate::wiring::connect::direction;
use crate::wiring::feed::{self, FeedError};

/// Values a second that a stream looks for when it is not told.
const USUAL_RATE: f64 = 50.0;
/// Values a second that a stream looks for at most.
const GREATEST_RATE: f64 = 1000.0;

/// `?element=ID`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ValueParameters {
    /// Element of a multiple port.
    element: Option<String>,
}

/// `?rate=HERTZ&element=ID`
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StreamParameters {
    /// Element of a multiple port.
    element: Option<String>,
    /// Values a second, at most.
    rate: Option<f64>,
}

/// `GET /ports`
pub(crate) async fn all(State(daemon): State<Arc<Daemon>>) -> Json<Value> {
    let components = daemon.components.all();
    let ports: Vec<_> = components.iter().flat_map(|hosted| described(hosted)).collect();
    Json(json!({ "ports": ports }))
}

/// `GET /components/{component}/ports`
pub(crate) async fn of_component(
    State(daemon): State<Arc<Daemon>>,
    Path(component): Path<String>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    Ok(Json(json!({ "ports": described(&hosted) })))
}

/// `GET /components/{component}/ports/{port}`
pub(crate) async fn value(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<ValueParameters>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = find(&hosted, &port)?;
    let element = element(&hosted, index, parameters.element)?;
    Ok(Json(port_json(&hosted, index, element.as_deref())))
}

/// `POST /components/{component}/ports/{port}` with a value
///
/// Publishes it to an in port, and connects the port to what is published here the first time.
/// Members that are left out keep the value they had.
pub(crate) async fn publish(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<ValueParameters>,
    Body(value): Body<Value>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = find(&hosted, &port)?;
    let element = element(&hosted, index, parameters.element)?;
    let address = hosted.address(&port, element.as_deref());
    let work = tokio::task::spawn_blocking(move || {
        feed::publish(&daemon, &hosted, index, element.as_deref(), &value)
    });
    match work.await {
        Ok(Ok(value)) => Ok(Json(json!({"address": address.to_string(), "value": value}))),
        Ok(Err(error)) => Err(not_published(&error)),
        Err(error) => Err(RpcError::internal(error.to_string())),
    }
}

fn not_published(error: &FeedError) -> RpcError {
    let message = error.to_string();
    match error {
        FeedError::OutPort(_) => RpcError::conflict("out_port", message),
        FeedError::Connected { inport, .. } => RpcError::conflict("connected", message)
            .help(format!("`genomctl disconnect {inport}` first, to feed it from here")),
        FeedError::Value(error) => RpcError::bad_input(message).place(error.path.clone()),
        FeedError::Open(OpenError::Taken { .. }) => RpcError::conflict("taken", message)
            .help("another program publishes there: stop it first"),
        FeedError::Backend(_) | FeedError::Open(_) | FeedError::Publish { .. } => {
            RpcError::new(StatusCode::BAD_GATEWAY, "middleware_failed", message)
        }
    }
}

/// `GET /components/{component}/ports/{port}/type`
///
/// What a program needs that reads or writes the port on its middleware itself.
pub(crate) async fn layout(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port)): Path<(String, String)>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = find(&hosted, &port)?;
    match hosted.port_type(index) {
        Some(ty) => Ok(Json(hosting::layout::of(ty))),
        None => Err(RpcError::internal(format!("{component}/{port} has no type"))),
    }
}

/// `GET /components/{component}/ports/{port}/traffic`
///
/// Counts whose differences give rates: `genomctl hz` and `genomctl bw`.
pub(crate) async fn traffic(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<ValueParameters>,
) -> Result<Json<Value>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = find(&hosted, &port)?;
    let element = element(&hosted, index, parameters.element)?;
    let address = hosted.address(&port, element.as_deref());
    let Some(gauge) = hosted.wiring.gauge(index, element.as_deref()) else {
        let message = format!("nothing passes through {address}: it is not connected");
        return Err(RpcError::conflict("not_connected", message)
            .help(format!("`genomctl connect {address} COMPONENT/PORT`")));
    };
    let mut reply = json!(gauge.traffic());
    reply["address"] = address.to_string().into();
    Ok(Json(reply))
}

/// `GET /components/{component}/ports/{port}/stream`
///
/// Events `value` when the value is another than the last one sent, the first at once if there
/// is one; event `end` when the component is unloaded.
pub(crate) async fn stream(
    State(daemon): State<Arc<Daemon>>,
    Path((component, port)): Path<(String, String)>,
    Parameters(parameters): Parameters<StreamParameters>,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>>>, RpcError> {
    let hosted = components::find(&daemon, &component)?;
    let index = find(&hosted, &port)?;
    let element = element(&hosted, index, parameters.element)?;
    let rate = parameters.rate.unwrap_or(USUAL_RATE);
    if !(rate > 0.0 && rate <= GREATEST_RATE) {
        let message = format!("rate: {rate} is not between 0 and {GREATEST_RATE} values a second");
        return Err(RpcError::bad_input(message).place("rate"));
    }
    stream::open(&daemon, move |writer| follow(hosted, index, element, rate, writer))
}

async fn follow(
    hosted: Arc<Hosted>,
    port: usize,
    element: Option<String>,
    rate: f64,
    writer: Writer,
) {
    let mut ticks = interval(Duration::from_secs_f64(1.0 / rate));
    ticks.set_missed_tick_behavior(MissedTickBehavior::Skip);
    let mut last = None;
    loop {
        tokio::select! {
            _ = ticks.tick() => {}
            () = writer.closed() => return,
            () = hosted.gone.raised() => {
                let why = json!({"why": "the component was unloaded"}).to_string();
                writer.send(Event::default().event("end").data(why)).await;
                return;
            }
        }
        let Some(value) = hosted.port_value(port, element.as_deref()) else { continue };
        if last.as_ref() == Some(&value) {
            continue;
        }
        if !writer.send(Event::default().event("value").data(value.to_string())).await {
            return;
        }
        last = Some(value);
    }
}

/// The port of that name.
pub(super) fn find(hosted: &Hosted, port: &str) -> Result<usize, RpcError> {
    let ports = &hosted.model().ports;
    ports.iter().position(|found| found.name == port).ok_or_else(|| {
        let what = format!("{} has no port", hosted.name);
        let names = ports.iter().map(|port| port.name.as_str());
        RpcError::unknown("no_such_port", what, port, names)
    })
}

/// A multiple port needs an element, a single one has none.
fn element(
    hosted: &Hosted,
    port: usize,
    element: Option<String>,
) -> Result<Option<String>, RpcError> {
    let port = &hosted.model().ports[port];
    let message = match (port.multiple, &element) {
        (true, None) => {
            format!("{}/{} is a multiple port: name an element", hosted.name, port.name)
        }
        (false, Some(element)) => {
            format!("{}/{} has no element `{element}`: it is single", hosted.name, port.name)
        }
        _ => return Ok(element),
    };
    Err(RpcError::bad_input(message).place("element"))
}

/// The port itself, or the elements of a multiple one.
pub(super) fn elements(hosted: &Hosted, port: usize) -> Vec<Option<String>> {
    if hosted.model().ports[port].multiple {
        hosted.wiring.elements(port).into_iter().map(Some).collect()
    } else {
        vec![None]
    }
}

fn described(hosted: &Hosted) -> Vec<Value> {
    let mut out = Vec::new();
    for index in 0..hosted.model().ports.len() {
        let elements = elements(hosted, index);
        if elements.is_empty() {
            out.push(port_json(hosted, index, None));
        }
        out.extend(elements.iter().map(|id| port_json(hosted, index, id.as_deref())));
    }
    out
}

fn port_json(hosted: &Hosted, index: usize, element: Option<&str>) -> Value {
    let port = &hosted.model().ports[index];
    let mut out = Map::new();
    out.insert("address".into(), hosted.address(&port.name, element).to_string().into());
    out.insert("name".into(), port.name.as_str().into());
    out.insert("direction".into(), direction(port.direction).into());
    out.insert("multiple".into(), port.multiple.into());
    out.insert("type".into(), hosted.specification().types.spelling(port.ty).into());
    out.extend(port.doc.clone().map(|doc| ("doc".to_owned(), Value::from(doc))));
    let connected = hosted.wiring.connection(index, element);
    if let Some(connection) = connected {
        out.insert("connected".into(), connection.outport.to_string().into());
    }
    out.insert("backend".into(), hosted.wiring.bindings.port(&port.name).to_string().into());
    if let Some(gauge) = hosted.wiring.gauge(index, element) {
        out.insert("traffic".into(), json!(gauge.counts()));
    }
    if let Some(value) = hosted.port_value(index, element) {
        out.insert("value".into(), value);
    }
    Value::Object(out)
}
