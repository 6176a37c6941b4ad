//! The types that cross the control plane of genomd, each defined once.
//!
//! Each file holds the requests, queries and replies of one resource. [`routes`] lists the paths
//! with the types of their bodies and replies, so that a client cannot read a reply as another
//! type. All errors have the form of [`Refusal`], and their reasons are listed in [`Code`].
//!
//! ```
//! use genom_protocol::{Address, PortParameters, routes};
//!
//! // GET /ports, which answers `Ports`, without their values.
//! let route = routes::ports().with(&PortParameters { values: Some(false) });
//! assert_eq!(route.path, "/ports?values=false");
//!
//! let Address { component, port, element } = "arm/cameras/left".parse()?;
//! assert_eq!((component.as_str(), port.as_str()), ("arm", "cameras"));
//! assert_eq!(element.as_deref(), Some("left"));
//! # Ok::<(), genom_protocol::address::NoAddress>(())
//! ```
//!
//! Requests with unknown members are refused. Replies may have members that a later daemon added,
//! and optional members may be missing.

#![forbid(unsafe_code)]

mod about;
mod activities;
pub mod address;
pub mod advice;
mod backends;
mod blackbox;
mod cells;
mod clock;
mod code;
mod codels;
mod components;
mod connections;
pub mod contexts;
mod crashes;
mod daemons;
mod deployment;
mod description;
mod doctor;
mod events;
mod execution;
mod findings;
pub mod frames;
pub mod freeze;
mod kept;
mod load;
mod logs;
mod middlewares;
mod notes;
mod on_failure;
#[cfg(feature = "openapi")]
pub mod openapi;
mod outcome;
mod plots;
mod policy;
mod port_type;
mod ports;
mod quality;
mod refusal;
mod reload;
mod remap;
mod remedies;
pub mod replay;
mod requests;
mod right;
pub mod routes;
mod services;
mod several;
pub mod socket;
mod sources;
pub mod sse;
mod state;
mod statistics;
pub mod supervision;
mod timeline;
mod tokens;
mod type_kind;
pub mod units;
mod values;
mod web;
mod withheld;

pub use about::{About, Ready, ReadyParameters, Stopping};
pub use activities::{
    Aborted, AbortedActivity, Activities, Activity, AllAborted, LookParameters, Status,
};
pub use address::{Address, Place, Subject, component_of};
pub use backends::{BackendNames, MoveRequest, Moved, NeededEnds};
pub use blackbox::{BlackBox, BlackBoxFile, BlackBoxLeft, BlackBoxPart};
pub use cells::{Cell, CellEnds, CellState, Cells, RestartPolicy};
pub use clock::{Clock, ClockKind, StepRequest};
pub use code::Code;
pub use codels::{RunningCodel, Spin, Unpaused};
pub use components::{Component, Components, LeftBehind, Unloaded};
pub use connections::{Connection, ConnectionKind, ConnectionRequest, Connections, Disconnected};
pub use crashes::{Crash, CrashFault, CrashFrame, CrashReport, CrashedComponent, Crashes};
pub use daemons::{Answered, Answers, AskParameters, Daemons, VisibleDaemon};
pub use deployment::{
    Applied, CallEntry, ConnectionEntry, Deployment, DeploymentRequest, Dumped, RunningDeployment,
    TakenBack,
};
pub use description::{
    Codel, CodelParameter, Description, Direction, Member, Parameter, PortDescription,
    RemoteDescription, Service, ServiceKind, TaskDescription,
};
pub use doctor::{Diagnosis, DoctorParameters, Examined, Severity};
pub use events::{AnyChange, Change, ChangeParameters, Fired, StepStatus};
pub use execution::ExecutionKind;
pub use findings::{Finding, Findings};
pub use frames::{RecordingEnds, RecordingRequest};
pub use freeze::{Frozen, GoesOn, ThawRequest, Thawed, ThawedComponent};
pub use kept::{
    KeepRequest, KeptRecording, KeptRecordings, KeptReplay, KeptState, RecordingRemoved,
    ReplayRequest,
};
pub use load::{LoadRequest, TaskEntry};
pub use logs::{Level, LogEntry, LogParameters, Logs};
pub use middlewares::{
    Capabilities, Endpoint, EndpointKind, Middleware, MiddlewareParameters, Middlewares, Refused,
    Stranger, Trouble,
};
pub use notes::NoteKind;
pub use on_failure::{Act, Deed, NoReaction, Reaction};
pub use outcome::Outcome;
pub use plots::{Column, ColumnsOfPlot, ImageParameters, Plot, PlotColumns, PlotParameters, Plots};
pub use policy::{NoPolicy, Policy};
pub use port_type::{MessageType, PortType};
pub use ports::{
    Counts, Port, PortDirection, PortParameters, PortTraffic, Ports, Published, Traffic,
    ValueParameters,
};
pub use quality::{PortQos, QosEntry};
pub use refusal::{Reason, Refusal};
pub use reload::{ComponentReload, ReloadRequest};
pub use remap::{BadRemap, Remap, Renamed, is_ros_part, renamed};
pub use remedies::{Choice, Remedy};
pub use replay::Replayed;
pub use right::Right;
pub use routes::STANDARD_SERVICES;
pub use services::{CallParameters, CallReply, Inputs, Started};
pub use sources::{SourceText, Sources, TaskSettings};
pub use state::{
    FrozenActivity, FrozenCall, FrozenComponent, FrozenPhase, FrozenState, FrozenValue, FrozenWait,
    Restore, Resumption,
};
pub use statistics::{
    Bucket, CodelStatistics, Durations, Histograms, Statistics, TaskHistograms, TaskStatistics,
    Yielded,
};
pub use supervision::{
    Beats, Broken, Condition, Kind, MOST_RULES, NoRule, OwnResponse, Response, Rule,
    SupervisionEntry, Whose,
};
pub use timeline::{Dated, Timeline, TimelineParameters};
pub use tokens::{Reloaded, TokenEntry, TokenFile};
pub use type_kind::{TypeKind, TypeMember};
pub use values::{Form, StreamEnd, StreamParameters};
pub use web::{Link, LinkRequest};
pub use withheld::{Cleared, Withheld, WithheldFor};

/// Whether a flag is false: it is then left out of the JSON.
fn is_false(flag: &bool) -> bool {
    !flag
}
