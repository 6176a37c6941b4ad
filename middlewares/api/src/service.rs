//! Services on a middleware: attributes, functions and activities, served and called.
//!
//! All three have the same shape: a request carries an input record, and a [`Replies`] receives
//! what comes back. Attributes and functions only finish. An activity is first accepted, may report
//! its states, and can be cancelled. The serving and the calling side use the same trait, so that a
//! backend within one process can pass it on unchanged.

use std::sync::Arc;
use std::time::Duration;

use genom_types::{DataType, Record};
use serde::{Deserialize, Serialize};

use crate::reply::{self, ActivityId, Outcome, Replies};
use crate::{Address, CallError, OpenError};

/// Kind of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ServiceKind {
    /// Reads or sets data of the component; replies at once.
    Attribute,
    /// Computes a result; replies at once.
    Function,
    /// Runs for some time: is accepted, reports states, ends with a result; can be cancelled.
    Activity,
}

/// Kind and types of a service.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ServiceType {
    /// Attribute, function or activity.
    pub kind: ServiceKind,
    /// Struct type of the `in` and `inout` parameters.
    pub input: DataType,
    /// Struct type of the `out` and `inout` parameters.
    pub output: DataType,
    /// Digest of the parameters and exceptions in its description (genom3.md 4.9); empty if
    /// unknown.
    pub described: String,
}

impl ServiceType {
    /// A service whose description is unknown.
    #[must_use]
    pub fn new(kind: ServiceKind, input: DataType, output: DataType) -> Self {
        Self { kind, input, output, described: String::new() }
    }

    /// The same service with the digest of its description.
    #[must_use]
    pub fn described(self, digest: impl Into<String>) -> Self {
        Self { described: digest.into(), ..self }
    }

    /// Digest of kind, types and description. Caller and server must have the same one (genom3.md
    /// 4.9, 7.3).
    #[must_use]
    pub fn digest(&self) -> String {
        let types = format!("{}-{}", self.input.digest(), self.output.digest());
        if self.described.is_empty() { types } else { format!("{types}-{}", self.described) }
    }
}

/// Serves and calls services.
pub trait Services {
    /// Serves a service until the result is dropped.
    ///
    /// # Errors
    /// The address is already served, or the middleware cannot serve.
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError>;

    /// Opens the calling end of a service. The service may appear later, disappear and come back.
    ///
    /// # Errors
    /// When the middleware cannot call.
    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError>;
}

/// Handles the requests to a service.
pub trait ServiceHandler: Send + Sync {
    /// Called for each request. Must not block until the service ends: the reply goes into
    /// `replies`, before this returns or later.
    fn request(&self, input: Record, replies: Box<dyn Replies>);

    /// The caller cancels an activity. Does nothing if the activity has already ended.
    fn cancel(&self, id: ActivityId);
}

/// A served service. Dropping it withdraws the service.
pub trait Served: Send {}

/// The calling end of a service.
pub trait Client: Send {
    /// Sends a request and returns; the reply goes into `replies`.
    ///
    /// # Errors
    /// Nobody serves the address, the types differ, or the middleware fails.
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError>;

    /// Sends a request and waits at most `timeout` for its outcome.
    ///
    /// # Errors
    /// The same as [`request`](Client::request), or nothing came in time.
    fn call(&mut self, input: &Record, timeout: Duration) -> Result<Outcome, CallError> {
        let (replies, answer) = reply::pair();
        let _running = self.request(input, Box::new(replies))?;
        answer.wait(timeout)
    }
}

/// A request in progress. Dropping it does not cancel it.
pub trait Running: Send {
    /// Cancels an activity. Its outcome still arrives through its [`Replies`].
    fn cancel(&self);
}
