//! A place to wait for the reply to one request.

use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::{Duration, Instant};

use crate::CallError;
use crate::service::{ActivityId, Outcome, Replies};

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

// A caller that no longer waits is no error of the service.
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
