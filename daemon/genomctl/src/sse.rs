//! Reads server-sent events (event streams of the HTML standard) from a reply's body.

use std::collections::VecDeque;

use crate::body::Body;
use crate::failure::Failure;

/// A server-sent event.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Event {
    /// `event:`, empty for plain messages.
    pub(crate) kind: String,
    /// `data:` lines, joined.
    pub(crate) data: String,
    /// `id:`, with which the stream can be resumed.
    pub(crate) id: Option<u64>,
}

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
            if let Some(event) = self.parser.ready.pop_front() {
                return Ok(Some(event));
            }
            let Some(bytes) = self.body.next().await? else { return Ok(None) };
            self.parser.feed(&bytes);
        }
    }
}

/// Parses bytes into events; a piece may end anywhere.
#[derive(Debug, Default)]
struct Parser {
    /// Bytes of an incomplete line.
    line: Vec<u8>,
    /// The event that the next empty line completes.
    event: Event,
    /// Whether `event` has data: events without data are dropped.
    filled: bool,
    ready: VecDeque<Event>,
}

impl Parser {
    fn feed(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            if byte == b'\n' {
                let line = String::from_utf8_lossy(&std::mem::take(&mut self.line)).into_owned();
                self.take_line(line.trim_end_matches('\r'));
            } else {
                self.line.push(byte);
            }
        }
    }

    fn take_line(&mut self, line: &str) {
        if line.is_empty() {
            let event = std::mem::take(&mut self.event);
            if std::mem::take(&mut self.filled) {
                self.ready.push_back(event);
            }
            return;
        }
        let (field, value) = line.split_once(':').unwrap_or((line, ""));
        let value = value.strip_prefix(' ').unwrap_or(value);
        match field {
            "event" => self.event.kind = value.to_owned(),
            "data" => {
                if self.filled {
                    self.event.data.push('\n');
                }
                self.event.data.push_str(value);
                self.filled = true;
            }
            "id" => self.event.id = value.parse().ok(),
            // `retry`, and comments that keep the connection alive.
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_survive_any_cut() {
        let text = b": hello\r\nevent: value\nid: 7\ndata: {\"a\":1}\n\ndata: x\ndata: y\n\n";
        for cut in 0..text.len() {
            let mut parser = Parser::default();
            parser.feed(&text[..cut]);
            parser.feed(&text[cut..]);
            let found: Vec<Event> = parser.ready.into();
            let first = Event { kind: "value".into(), data: "{\"a\":1}".into(), id: Some(7) };
            let second = Event { kind: String::new(), data: "x\ny".into(), id: None };
            assert_eq!(found, [first, second]);
        }
    }
}
