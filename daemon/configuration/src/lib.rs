//! What a daemon is to do, in the words of those who write it: the configuration file, deployment
//! files, and the requests that say the same.
//!
//! It says what is wanted, and where in a file it stands. It knows no component that runs, no HTTP
//! and no command line.

#![forbid(unsafe_code)]

mod error;
mod file;
pub mod levels;
mod offers;
mod overrides;
pub mod place;
mod rpc;
mod spot;
pub mod terms;

pub use error::{
    ConfigError, MOST_ACTIVITIES, NoCollector, NoLevel, NoPeriod, SetError, UsageError, WhichDaemon,
};
pub use file::{Config, MemoryCheck, Telemetry};
pub use genom_protocol::{
    BackendNames, CallEntry, ClockKind, ConnectionEntry, Deployment, LoadRequest, PortQos,
    QosEntry, Right, TaskEntry,
};
pub use offers::Offers;
pub use rpc::{Rpc, RpcSettings, Tls};
pub use spot::Spot;
