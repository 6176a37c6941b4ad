//! Services of all components of a daemon, over one request-response service of iceoryx2.
//!
//! Each daemon that serves anything has a service `genom.calls/<its node>` with one server; each
//! daemon that calls it has one client there. A request starts with the address of the service it
//! is for ([`frame`]) and may get many responses. When either side drops it, the other side
//! notices. What a daemon serves is listed in its [`catalog`](crate::catalog), so that announcing a
//! service costs neither file descriptors nor shared memory. An event wakes a thread of each daemon
//! whenever something was sent; the thread passes it on.

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
