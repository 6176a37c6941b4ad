//! The replies to one request, and a channel to wait for them.

use std::fmt;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use genom_types::Record;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::CallError;

/// One accepted run of an activity; unique within the component instance that serves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ActivityId(pub u64);

impl fmt::Display for ActivityId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// How a request ended.
#[derive(Debug)]
pub enum Outcome {
    /// Success; the record has the service's output type.
    Success(Record),
    /// An exception. An interrupted activity ends with `::genom::interrupted`.
    Exception {
        /// Full name of the exception, such as `::demo::TOO_FAR_AWAY`.
        name: String,
        /// Members of the exception as JSON; null when it has none.
        detail: Value,
    },
    /// The connection broke first; how the service ended is unknown.
    Lost(CallError),
}

/// Receives the replies to one request. Called from any thread, one call at a time.
///
/// Dropping it without [`finish`](Replies::finish) means [`CallError::Gone`]: an implementation
/// whose caller waits must report that in `Drop`.
pub trait Replies: Send {
    /// The activity was accepted under this id. Called first, and only for activities.
    fn accepted(&mut self, id: ActivityId);

    /// The activity entered the given state.
    fn feedback(&mut self, state: &str);

    /// The request ended.
    fn finish(self: Box<Self>, outcome: Outcome);
}

/// One reply; they arrive in order.
#[derive(Debug)]
pub enum Reply {
    /// The activity was accepted.
    Accepted(ActivityId),
    /// The activity entered a state.
    Feedback(String),
    /// The request ended.
    Finished(Outcome),
}

/// The service's end of the channel.
#[derive(Debug)]
pub struct ReplySender(Sender<Reply>);

/// The caller's end of the channel.
#[derive(Debug)]
pub struct ReplyReceiver(Receiver<Reply>);

/// Creates a channel for the replies to one request.
///
/// ```
/// use std::time::Duration;
/// use genom_middleware::reply::{Reply, pair};
/// use genom_middleware::{CallError, Outcome, Replies};
///
/// let (sender, replies) = pair();
/// let mut service: Box<dyn Replies> = Box::new(sender);
/// service.feedback("main");
/// let (name, detail) = ("::demo::TOO_FAR_AWAY".to_owned(), serde_json::Value::Null);
/// service.finish(Outcome::Exception { name, detail });
/// let first = replies.next(Duration::from_secs(1))?;
/// assert!(matches!(first, Reply::Feedback(state) if state == "main"));
/// let outcome = replies.wait(Duration::from_secs(1))?;
/// assert!(matches!(outcome, Outcome::Exception { name, .. } if name == "::demo::TOO_FAR_AWAY"));
/// # Ok::<(), CallError>(())
/// ```
#[must_use]
pub fn pair() -> (ReplySender, ReplyReceiver) {
    let (sender, receiver) = channel();
    (ReplySender(sender), ReplyReceiver(receiver))
}

// Sending fails when the caller gave up waiting; the service need not know.
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
    /// Waits at most `timeout` for the next reply.
    ///
    /// # Errors
    /// Nothing came in time, or the service went away.
    pub fn next(&self, timeout: Duration) -> Result<Reply, CallError> {
        self.0.recv_timeout(timeout).map_err(|error| match error {
            RecvTimeoutError::Timeout => CallError::Timeout(timeout),
            RecvTimeoutError::Disconnected => CallError::Gone,
        })
    }

    /// Waits at most `timeout` for the outcome, and skips the replies before it.
    ///
    /// # Errors
    /// The request did not end in time, the service went away, or the outcome is
    /// [`Outcome::Lost`].
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
