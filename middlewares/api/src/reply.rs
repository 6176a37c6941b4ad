//! What comes back for one request, and a place to wait for it.

use std::fmt;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use genom_types::Record;
use serde_json::Value;

use crate::CallError;

/// One accepted run of an activity, unique within the instance that serves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ActivityId(pub u64);

impl fmt::Display for ActivityId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// How a request ended.
#[derive(Debug)]
pub enum Outcome {
    /// It ended well; the record is of the service's output type.
    Success(Record),
    /// It ended with an exception; an interrupted activity ends with `::genom::interrupted`.
    Exception {
        /// Full name: `::demo::TOO_FAR_AWAY`.
        name: String,
        /// Its members as JSON; null when it has none.
        detail: Value,
    },
    /// The connection ended first; how the service ended is not known.
    Lost(CallError),
}

/// Takes what comes back for one request. Called from any thread, one call at a time.
///
/// Dropping it without [`finish`](Replies::finish) tells the caller [`CallError::Gone`]:
/// implementations that somebody waits on must do so in `Drop`.
pub trait Replies: Send {
    /// The activity was accepted under this id. Comes first, and for activities only.
    fn accepted(&mut self, id: ActivityId);

    /// The activity entered this state.
    fn feedback(&mut self, state: &str);

    /// The request ended.
    fn finish(self: Box<Self>, outcome: Outcome);
}

/// What came back, in order.
#[derive(Debug)]
pub enum Reply {
    /// The activity was accepted.
    Accepted(ActivityId),
    /// The activity entered a state.
    Feedback(String),
    /// The request ended.
    Finished(Outcome),
}

/// The end a service writes to.
#[derive(Debug)]
pub struct ReplySender(Sender<Reply>);

/// The end a caller waits on.
#[derive(Debug)]
pub struct ReplyReceiver(Receiver<Reply>);

/// Two ends of one request.
#[must_use]
pub fn pair() -> (ReplySender, ReplyReceiver) {
    let (sender, receiver) = channel();
    (ReplySender(sender), ReplyReceiver(receiver))
}

// The receiving end is gone when the caller gave up waiting: nothing to report to the service.
impl Replies for ReplySender {
    fn accepted(&mut self, id: ActivityId) {
        let _ = self.0.send(Reply::Accepted(id));
    }

    fn feedback(&mut self, state: &str) {
        let _ = self.0.send(Reply::Feedback(state.to_owned()));
    }

    fn finish(self: Box<Self>, outcome: Outcome) {
        let _ = self.0.send(Reply::Finished(outcome));
    }
}

impl ReplyReceiver {
    /// The next thing that comes back, within `timeout`.
    ///
    /// # Errors
    /// Nothing came in time, or the service went away.
    pub fn next(&self, timeout: Duration) -> Result<Reply, CallError> {
        self.0.recv_timeout(timeout).map_err(|error| match error {
            RecvTimeoutError::Timeout => CallError::Timeout(timeout),
            RecvTimeoutError::Disconnected => CallError::Gone,
        })
    }

    /// How the request ended, within `timeout`.
    ///
    /// # Errors
    /// It did not end in time, or the service went away.
    pub fn wait(&self, timeout: Duration) -> Result<Outcome, CallError> {
        let end = Instant::now() + timeout;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            match self.next(left) {
                Ok(Reply::Finished(Outcome::Lost(error))) => return Err(error),
                Ok(Reply::Finished(outcome)) => return Ok(outcome),
                Ok(Reply::Accepted(_) | Reply::Feedback(_)) => {}
                Err(CallError::Timeout(_)) => return Err(CallError::Timeout(timeout)),
                Err(error) => return Err(error),
            }
        }
    }
}
