//! What users tell a daemon to do: the configuration file, deployment files, and requests of the
//! same content.
//!
//! This crate only reads and checks them, and tells where in a file a mistake is. It depends
//! neither on running components nor on HTTP or the command line.

#![forbid(unsafe_code)]

mod blackbox;
mod cells;
mod container;
mod crashes;
mod error;
mod file;
mod foxglove;
mod gateways;
pub mod levels;
mod lifecycle;
mod limits;
mod offers;
mod overrides;
mod pattern;
pub mod place;
mod plugins;
mod recordings;
mod reload;
mod rpc;
mod runners;
mod spot;
mod states;
pub mod terms;
mod web;

pub use blackbox::{BlackBoxReason, BlackBoxSection, is_one_of};
pub use cells::{CellSettings, CellsSection, WithoutDaemon};
pub use container::ContainerSection;
pub use crashes::CrashesSection;
pub use error::{
    ConfigError, MOST_ACTIVITIES, NoCollector, NoLevel, NoPeriod, SetError, UsageError, WhichDaemon,
};
pub use file::{Config, MemoryCheck, Telemetry};
pub use foxglove::FoxgloveSection;
pub use gateways::GatewaysSection;
pub use genom_protocol::{
    Act, BackendNames, CallEntry, ClockKind, Condition, ConnectionEntry, Deed, Deployment,
    ExecutionKind, LoadRequest, OwnResponse, PortQos, QosEntry, Reaction, Right, SupervisionEntry,
    TaskEntry, Whose,
};
pub use lifecycle::LifecycleSection;
pub use limits::CellLimits;
pub use offers::Offers;
pub use pattern::matches;
pub use recordings::RecordingsSection;
pub use reload::ReloadSection;
pub use rpc::{Rpc, RpcSettings, Tls};
pub use runners::{RunnerSection, Runners};
pub use spot::Spot;
pub use web::WebSection;
