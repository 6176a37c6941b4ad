//! Requests to a daemon: who may make them, and the replies.

mod access;
mod bags;
mod daemons;
mod document;
mod doors;
mod frozen;
mod fuzz;
mod impostors;
pub(crate) mod metrics;
mod offers;
mod partial;
mod protocol;
mod publish;
mod python_client;
mod ready;
pub(crate) mod recording;
mod sources;
mod stepped;
mod streams;
mod telemetry;
mod undisturbed;
