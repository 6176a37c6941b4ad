//! Runs components: finds, loads, connects, moves, deploys and records them, and takes them down.
//!
//! A [`daemon::Daemon`] holds what runs. `loading` brings a component up, `wiring` binds and
//! connects its ports and services, `deploy` takes the steps from what runs to what is wanted,
//! `recording` sends what passes, and `vigil` looks after codels that do not return. It speaks no
//! HTTP and reads no command line: `genomd` puts a control plane before it, and another program may
//! do without one.

#![forbid(unsafe_code)]

pub mod bus;
pub mod daemon;
pub mod deploy;
pub mod ending;
pub mod flag;
pub mod hosting;
pub mod known;
pub mod limits;
pub mod loading;
pub mod recording;
pub mod settings;
pub mod spans;
pub mod vigil;
pub mod wires;
pub mod wiring;
