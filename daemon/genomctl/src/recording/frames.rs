//! The frames of a recording, cut from what the daemon sends.

use genom_protocol::frames::{Frame, complete};

use crate::body::Body;
use crate::failure::Failure;

/// The frames of one recording, in order.
pub(crate) struct Frames {
    body: Body,
    /// What came, with frames that were handed over before what was not.
    bytes: Vec<u8>,
    /// Where the next frame begins.
    next: usize,
}

impl Frames {
    pub(crate) fn new(body: Body) -> Self {
        Self { body, bytes: Vec::new(), next: 0 }
    }

    /// The next frame; `None` when the daemon went away or sent nonsense, a failure when it answers
    /// nobody any more. Nothing is lost when the future is dropped before it is ready.
    pub(crate) async fn next(&mut self) -> Result<Option<Frame<'_>>, Failure> {
        let length = loop {
            match complete(&self.bytes[self.next..]) {
                Err(_) => return Ok(None),
                Ok(Some(length)) => break length,
                Ok(None) => {}
            }
            self.bytes.drain(..self.next);
            self.next = 0;
            let Some(bytes) = self.body.next().await? else { return Ok(None) };
            self.bytes.extend_from_slice(&bytes);
        };
        let begin = self.next;
        self.next += length;
        let frame = Frame::first(&self.bytes[begin..self.next]);
        Ok(frame.ok().flatten().map(|(frame, _)| frame))
    }
}
