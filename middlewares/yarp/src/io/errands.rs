//! Short conversations with ports of others: a request, and what comes back.

use std::time::Duration;

use genom_middleware::{Address, CallError};

use crate::error::BACKEND;
use crate::wire::Carrier;

/// How long a peer may take until it answers an errand that does not wait.
const TO_ANSWER: Duration = Duration::from_secs(3);

/// Greatest number of bytes of an answer to an errand that does not expect less.
const MOST_HEARD: usize = 64 << 20;

/// A conversation. Its methods are called on the thread of connections, and do not block.
pub(crate) trait Errand: Send {
    /// The carrier of the connection.
    fn carrier(&self) -> Carrier;

    /// What is sent once the peer has greeted.
    fn begin(&mut self) -> Vec<u8>;

    /// Sees all bytes that have come and that no step has used up.
    fn hear(&mut self, bytes: &[u8]) -> Step;

    /// The connection broke, or never stood.
    fn lost(self: Box<Self>, how: Lost);

    /// How long the peer may take until its next answer begins; `None` for any time.
    fn patience(&self) -> Option<Duration> {
        Some(TO_ANSWER)
    }

    /// Greatest number of bytes of an answer.
    fn most(&self) -> usize {
        MOST_HEARD
    }
}

/// What a conversation does next.
pub(crate) enum Step {
    /// More has to come.
    Wait,
    /// So many bytes are used up; these are sent.
    Send(usize, Vec<u8>),
    /// The connection is closed.
    Done,
}

/// How a conversation broke.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Lost {
    /// Nobody listens there.
    Nobody,
    /// It could not begin, for another reason.
    Unreachable(String),
    /// The peer ended the connection.
    Gone,
    /// No answer began within this time.
    Late(Duration),
}

impl Lost {
    /// What the caller of a service is told.
    pub(crate) fn into_call_error(self, at: &Address) -> CallError {
        match self {
            Lost::Nobody => CallError::Nobody { address: at.clone() },
            Lost::Gone => CallError::Gone,
            Lost::Late(after) => CallError::Timeout(after),
            Lost::Unreachable(why) => CallError::Failed { backend: BACKEND.to_owned(), why },
        }
    }
}
