//! What is asked of a daemon, by whom, and what it answers.

mod access;
mod daemons;
mod document;
mod doors;
mod frozen;
mod fuzz;
mod impostors;
mod metrics;
mod offers;
mod partial;
mod protocol;
mod publish;
mod python_client;
mod ready;
mod recording;
mod stepped;
mod streams;
mod telemetry;
mod undisturbed;
