//! Services over iceoryx2's request-response, `<instance>/<service>`.
//!
//! Requests and responses are byte slices: a request is the input as a CDR message, a response is
//! a [`frame`]. One request gets many responses; dropping it on either side tells the other. A
//! thread of each daemon is woken by an event when anything was sent, and hands it on.

mod bell;
mod call;
mod client;
mod frame;
mod serve;
mod server;
mod service;
mod worker;

pub(crate) use client::open as client;
pub(crate) use serve::open as serve;
pub(crate) use service::SERVICE_KEY;
pub(crate) use worker::Worker;
