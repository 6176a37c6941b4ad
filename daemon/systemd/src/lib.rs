//! What the daemon tells the service manager that started it (systemd, `Type=notify`).
//!
//! [`Invitation`] is what the manager left in the environment, [`Manager`] the way to it, and
//! [`heartbeat`] answers its watchdog for as long as the daemon does its work.
//!
//! The protocol is that of `sd_notify(3)` and `sd_watchdog_enabled(3)`: datagrams of `KEY=VALUE`
//! lines. Libraries for it look the socket up in the environment at each message. Here it is taken
//! out of the environment at once, so that neither codels nor cells can speak for the daemon.

#![forbid(unsafe_code)]

mod heartbeat;
mod invitation;
mod manager;

pub use heartbeat::{Signs, heartbeat};
pub use invitation::Invitation;
pub use manager::Manager;
