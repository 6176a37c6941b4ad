//! What a daemon is to do, in the words of those who write it: the configuration file, deployment
//! files, and the requests that say the same.
//!
//! It says what is wanted, and where in a file it stands. It knows no component that runs, no HTTP
//! and no command line.

#![forbid(unsafe_code)]

mod backends;
mod clock;
mod component;
mod deployment;
mod error;
mod file;
pub mod levels;
mod offers;
mod overrides;
pub mod place;
pub mod policy;
mod qos;
mod right;
mod rpc;
mod spot;

pub use backends::BackendNames;
pub use clock::ClockKind;
pub use component::{LoadRequest, TaskEntry};
pub use deployment::{CallEntry, ConnectionEntry, Deployment};
pub use error::{ConfigError, MOST_ACTIVITIES, UsageError, WhichDaemon};
pub use file::{Config, MemoryCheck, Telemetry};
pub use offers::Offers;
pub use qos::{PortQos, QosEntry};
pub use right::Right;
pub use rpc::{Rpc, RpcSettings, Tls};
pub use spot::Spot;
