//! Server-sent events (the HTML standard's event streams), read from the bytes of a reply.

use std::collections::VecDeque;

/// Header with the number of an event: the last one that a reader has heard, or the last one before what
/// a reply holds.
pub const LAST_EVENT_ID: &str = "last-event-id";

/// One event.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Event {
    /// `event:`, empty for plain messages.
    pub kind: String,
    /// `data:` lines, joined.
    pub data: String,
    /// `id:`, by which the stream is resumed.
    pub id: Option<u64>,
}

/// Cuts bytes into events; a frame may end anywhere.
#[derive(Debug, Default)]
pub struct Parser {
    /// Bytes of a line that is not complete yet.
    line: Vec<u8>,
    /// The event that the next empty line completes.
    event: Event,
    /// Whether `event` holds data: an event without data is dropped.
    filled: bool,
    ready: VecDeque<Event>,
}

impl Parser {
    /// The next event that is complete.
    #[allow(clippy::should_implement_trait, reason = "more may come after there was none")]
    pub fn next(&mut self) -> Option<Event> {
        self.ready.pop_front()
    }

    /// Takes the bytes that came next.
    pub fn feed(&mut self, bytes: &[u8]) {
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
