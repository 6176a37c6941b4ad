//! Runs GenoM3 components: finds, loads, connects, moves, deploys, records and unloads them.
//!
//! A [`Supervisor`] holds what is running. `loading` loads and starts a component, `connections`
//! binds, connects and moves its ports and services, `deploy` applies a deployment, `recording`
//! streams samples and calls, and `vigil` reports codels that do not return. The crate contains
//! neither HTTP nor a command line: `genomd` adds a control plane, and other programs can use it
//! directly:
//!
//! ```
//! use genom_supervisor::{LoadRequest, Settings, Supervisor};
//! use serde_json::json;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # use genom_components::{Paths, Purpose, build};
//! # let library = build(&Paths::of_workspace()?, "demo", Purpose::Test)?.library;
//! let supervisor = Supervisor::new(Settings::default());
//! // `library` is the path of demo.so, which has demo.gen beside it.
//! let demo = supervisor.load(&LoadRequest { library, ..LoadRequest::default() })?;
//! let outcome = demo.call("set_speed", &json!({ "velocity": 2.0 }))?;
//! assert_eq!(outcome.exception(), None);
//!
//! // A goal beyond the limits of the axis is refused by a validation codel.
//! let outcome = demo.call("goto", &json!({ "goal": 100.0 }))?;
//! assert_eq!(outcome.exception(), Some("::demo::OUT_OF_RANGE"));
//!
//! drop(demo);
//! assert!(supervisor.unload_all().is_empty());
//! # Ok(())
//! # }
//! ```

#![forbid(unsafe_code)]

pub use genom_bus::{self as bus, flag};
pub mod components;
pub mod connections;
pub mod deploy;
pub mod limits;
pub mod loading;
pub mod outcome;
pub mod reactor;
pub mod recording;
pub mod reloading;
pub mod settings;
pub mod spans;
pub mod supervisor;
pub mod ties;
mod vigil;
mod waiting;

pub use genom_configuration::LoadRequest;
pub use settings::{Settings, Trials};
pub use supervisor::Supervisor;
