//! Runs components: finds, loads, connects, moves, deploys and records them, and takes them down.
//!
//! A [`Supervisor`] holds what runs. `loading` brings a component up, `connections`
//! binds, connects and moves its ports and services, `deploy` takes the steps from what runs to what is wanted,
//! `recording` sends what passes, and `vigil` looks after codels that do not return. It speaks no
//! HTTP and reads no command line: `genomd` puts a control plane before it, and another program may
//! do without one:
//!
//! ```no_run
//! use genom_supervisor::{LoadRequest, Settings, Supervisor};
//! use serde_json::json;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let supervisor = Supervisor::new(Settings::default());
//! let library = "target/components/demo/demo.so".into();
//! let demo = supervisor.load(&LoadRequest { library, ..LoadRequest::default() })?;
//! let outcome = demo.call("set_speed", &json!({ "velocity": 2.0 }))?;
//! assert_eq!(outcome.exception(), None);
//! supervisor.unload_all();
//! # Ok(())
//! # }
//! ```

#![forbid(unsafe_code)]

pub mod bus;
pub mod components;
pub mod connections;
pub mod deploy;
pub mod ending;
pub mod flag;
pub mod known;
pub mod limits;
pub mod loading;
pub mod recording;
pub mod settings;
pub mod spans;
pub mod supervisor;
pub mod ties;
mod vigil;
mod waiting;

pub use genom_configuration::LoadRequest;
pub use settings::Settings;
pub use supervisor::Supervisor;
