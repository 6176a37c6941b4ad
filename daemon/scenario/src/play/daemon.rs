//! What plays a scenario needs of a daemon.

use std::future::Future;

use genom_protocol::Reason;
use genom_protocol::routes::{Bytes, Route};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// A daemon whose clock is virtual, and that nobody else steps. Its black box keeps activities.
pub trait Daemon {
    /// Makes a request with a body.
    fn send<R: DeserializeOwned, Q, B: Serialize>(
        &self,
        route: Route<R, Q, B>,
        body: &B,
    ) -> impl Future<Output = Result<R, Trouble>>;

    /// Makes a request without a body.
    fn ask<R: DeserializeOwned, Q>(
        &self,
        route: Route<R, Q>,
    ) -> impl Future<Output = Result<R, Trouble>>;

    /// Reads the whole of a reply that is not JSON.
    fn bytes<Q>(&self, route: Route<Bytes, Q>) -> impl Future<Output = Result<Vec<u8>, Trouble>>;

    /// Kills a process of this daemon, as a fault would.
    fn kill(&self, pid: u32) -> Result<(), Trouble>;

    /// Waits a moment of the machine's time, for what processes do by themselves.
    fn moment(&self) -> impl Future<Output = ()>;
}

/// A request was not done.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Trouble {
    /// The daemon refused it.
    #[error("{}", .0.message)]
    Refused(Reason),
    /// There is no daemon any more, or it replied something else.
    #[error("{0}")]
    Gone(String),
}
