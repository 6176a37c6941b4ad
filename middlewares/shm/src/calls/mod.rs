//! Services of all components of a daemon, over one request-response service of iceoryx2.
//!
//! Each daemon that serves anything has `genom.calls/<its node>`, with one server; each daemon
//! that calls it has one client there. A request names the service it is for ([`frame`]); one
//! request gets many responses; dropping it on either side tells the other. What a daemon serves
//! stands in its [`catalog`](crate::catalog), so that a service costs neither descriptor nor
//! memory to be found. A thread of each daemon is woken by an event when anything was sent, and hands it on.

mod bell;
mod call;
mod callers;
mod client;
mod desk;
mod frame;
mod hub;
mod meeting;
mod request;
mod served;
mod worker;

pub(crate) use client::open as client;
pub(crate) use desk::Desk;
pub(crate) use served::open as serve;
