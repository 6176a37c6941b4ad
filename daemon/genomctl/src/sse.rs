//! The server-sent events of a reply, one after the other.

use genom_protocol::sse::{Event, Parser};

use crate::body::Body;
use crate::failure::Failure;

/// The events of one reply, in order.
pub(crate) struct EventStream {
    body: Body,
    parser: Parser,
}

impl EventStream {
    /// Reads from `body`.
    pub(crate) fn new(body: Body) -> Self {
        Self { body, parser: Parser::default() }
    }

    /// The next event; `None` when the daemon closed the stream. Fails when the daemon answers no
    /// requests.
    pub(crate) async fn next(&mut self) -> Result<Option<Event>, Failure> {
        loop {
            if let Some(event) = self.parser.next() {
                return Ok(Some(event));
            }
            let Some(bytes) = self.body.next().await? else { return Ok(None) };
            self.parser.feed(&bytes);
        }
    }
}
