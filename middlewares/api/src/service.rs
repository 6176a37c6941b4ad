//! Services on a middleware: attributes, functions and activities, served and called.
//!
//! One shape for all: a request carries an input record, and a [`Replies`] takes what comes back.
//! Attributes and functions only finish; an activity is first accepted, may tell its states,
//! and can be cancelled. Served and calling side use the same trait, so that a backend within
//! one process hands it straight through.

use std::sync::Arc;
use std::time::Duration;

use genom_types::{DataType, Record};

use crate::reply::{self, ActivityId, Outcome, Replies};
use crate::{Address, CallError, OpenError};

/// What kind of service an address names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ServiceKind {
    /// Reads or sets data of the component; replies at once.
    Attribute,
    /// A computation; replies at once.
    Function,
    /// Runs for a while: accepted, then states, then a result; can be cancelled.
    Activity,
}

/// Kind and types of a service.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct ServiceType {
    /// Attribute, function or activity.
    pub kind: ServiceKind,
    /// Struct of the `in` and `inout` parameters.
    pub input: DataType,
    /// Struct of the `out` and `inout` parameters.
    pub output: DataType,
    /// Digest of its parameters and exceptions (genom3.md 4.9). Empty without a description.
    pub described: String,
}

impl ServiceType {
    /// A service without description.
    #[must_use]
    pub fn new(kind: ServiceKind, input: DataType, output: DataType) -> Self {
        Self { kind, input, output, described: String::new() }
    }

    /// The same, with the digest of its description.
    #[must_use]
    pub fn described(self, digest: impl Into<String>) -> Self {
        Self { described: digest.into(), ..self }
    }

    /// By which a caller and a server of one kind agree (genom3.md 4.9, 7.3).
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
    /// When the address is served already, or the middleware cannot serve.
    fn serve(
        &self,
        at: &Address,
        service: &ServiceType,
        handler: Arc<dyn ServiceHandler>,
    ) -> Result<Box<dyn Served>, OpenError>;

    /// Opens the calling end of a service. The service may come later, go and come back.
    ///
    /// # Errors
    /// When the middleware cannot call.
    fn client(&self, at: &Address, service: &ServiceType) -> Result<Box<dyn Client>, OpenError>;
}

/// What serves a service.
pub trait ServiceHandler: Send + Sync {
    /// A request arrived. Does not wait for the service: the answer goes into `replies`, from
    /// here or later.
    fn request(&self, input: Record, replies: Box<dyn Replies>);

    /// The caller gives up an activity. Nothing happens when it already ended.
    fn cancel(&self, id: ActivityId);
}

/// A service being served. Dropping it withdraws the service.
pub trait Served: Send {}

/// The calling end of a service.
pub trait Client: Send {
    /// Sends a request and returns; the answer goes into `replies`.
    ///
    /// # Errors
    /// Nobody serves the address, the types differ, or the middleware fails.
    fn request(
        &mut self,
        input: &Record,
        replies: Box<dyn Replies>,
    ) -> Result<Box<dyn Running>, CallError>;

    /// Sends a request and waits until it ended, at most `timeout`.
    ///
    /// # Errors
    /// As [`request`](Client::request), or nothing came back in time.
    fn call(&mut self, input: &Record, timeout: Duration) -> Result<Outcome, CallError> {
        let (replies, answer) = reply::pair();
        let _running = self.request(input, Box::new(replies))?;
        answer.wait(timeout)
    }
}

/// A request under way. Dropping it changes nothing: the service runs on.
pub trait Running: Send {
    /// Asks an activity to stop. It still ends through its [`Replies`].
    fn cancel(&self);
}
