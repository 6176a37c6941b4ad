//! Ports and services over YARP, spoken natively: no library of YARP is linked.
//!
//! An out port is the YARP port `/<component>/<port>`, which `yarp read` reads; an in port connects
//! to any name; services answer at `/<component>/rpc`, where people may type them (`yarp rpc`).
//! `docs/yarp.md` says what a YARP user finds.
//!
//! One thread ([`io`]) has all connections and waits for no peer; real-time threads fill outlets
//! only, which a sending thread empties. What arrives is not trusted: it is understood piece by
//! piece ([`inbound`]), within limits.

#![forbid(unsafe_code)]

mod admin;
mod backend;
mod bottle;
mod calls;
mod client;
mod core;
mod desk;
mod desks;
mod discovery;
mod error;
mod in_port;
mod inbound;
mod io;
mod jobs;
mod line;
mod mark;
mod names;
mod news;
mod options;
mod out_port;
mod port;
mod ports;
mod readers;
mod refusals;
mod replies;
mod reply;
mod runs;
mod services;
mod steward;
mod stranger;
mod wire;
mod words;

pub use backend::Yarp;
pub use error::YarpError;
pub use options::Options;
