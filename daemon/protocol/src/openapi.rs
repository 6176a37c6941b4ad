//! The schemas of the types of this crate, for the daemon's OpenAPI document.

use serde_json::{Map, Value};
use utoipa::OpenApi;

use crate::{
    Aborted, About, Activities, AllAborted, Answers, Applied, BlackBox, BlackBoxLeft, CellEnds,
    Cells, Change, Cleared, Clock, ComponentReload, Components, Connection, ConnectionRequest,
    Connections, CrashReport, Crashes, Daemons, DeploymentRequest, Description, Disconnected,
    Dumped, Examined, ExecutionKind, Findings, Fired, Frozen, GoesOn, Histograms, Inputs,
    KeepRequest, KeptRecording, KeptRecordings, KeptReplay, Link, LinkRequest, LoadRequest, Logs,
    Middlewares, MoveRequest, Moved, NeededEnds, PlotColumns, Plots, PortTraffic, PortType, Ports,
    Published, Ready, RecordingEnds, RecordingRemoved, RecordingRequest, Refusal, ReloadRequest,
    Reloaded, ReplayRequest, Replayed, Sources, Started, Statistics, StepRequest, Stopping,
    StreamEnd, TakenBack, ThawRequest, Thawed, Timeline, Unloaded, Withheld, frames,
};

/// Lists all types that cross the control plane, including those of streams and recordings, to
/// which no operation of the document refers.
#[derive(Debug, OpenApi)]
#[openapi(components(schemas(
    Aborted,
    About,
    Activities,
    AllAborted,
    Answers,
    Applied,
    BlackBox,
    BlackBoxLeft,
    CellEnds,
    Cells,
    Change,
    Cleared,
    Clock,
    ComponentReload,
    Components,
    Connection,
    ConnectionRequest,
    Connections,
    CrashReport,
    Crashes,
    Daemons,
    DeploymentRequest,
    Description,
    Disconnected,
    Dumped,
    Examined,
    ExecutionKind,
    Findings,
    Fired,
    Frozen,
    GoesOn,
    Histograms,
    Inputs,
    KeepRequest,
    KeptRecording,
    KeptRecordings,
    KeptReplay,
    Link,
    LinkRequest,
    LoadRequest,
    Logs,
    Middlewares,
    MoveRequest,
    Moved,
    NeededEnds,
    PlotColumns,
    Plots,
    PortTraffic,
    PortType,
    Ports,
    Published,
    Ready,
    RecordingEnds,
    RecordingRemoved,
    RecordingRequest,
    Refusal,
    ReloadRequest,
    Reloaded,
    ReplayRequest,
    Replayed,
    Sources,
    Started,
    Statistics,
    StepRequest,
    Stopping,
    StreamEnd,
    TakenBack,
    ThawRequest,
    Thawed,
    Timeline,
    Unloaded,
    Withheld,
    frames::Channel,
    frames::Channels,
    frames::End,
    frames::Lost,
    frames::Start
)))]
pub struct Protocol;

/// The schemas as JSON, by name of the type.
#[must_use]
pub fn schemas() -> Map<String, Value> {
    let components = Protocol::openapi().components.map(|all| serde_json::to_value(all.schemas));
    match components {
        Some(Ok(Value::Object(schemas))) => schemas,
        _ => Map::new(),
    }
}
