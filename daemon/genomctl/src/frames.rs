//! Splits what the daemon sends into the frames of a recording.

use genom_protocol::frames::{Frame, complete};

use crate::body::Body;
use crate::failure::Failure;

/// Reads the frames of one recording.
pub(crate) struct Frames {
    body: Body,
    /// Received bytes; those before `next` were returned already.
    bytes: Vec<u8>,
    /// Offset of the next frame.
    next: usize,
}

impl Frames {
    pub(crate) fn new(body: Body) -> Self {
        Self { body, bytes: Vec::new(), next: 0 }
    }

    /// The next frame; `None` when the daemon closed the connection or sent invalid data. Fails
    /// when the daemon answers no requests. Cancel safe.
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
