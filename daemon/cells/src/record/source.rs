//! A process whose frames are recorded.

use std::sync::Arc;

use genom_protocol::frames::{End, Frame};
use genom_protocol::routes;

use super::merger::{Merger, Origin};
use crate::cell::Cell;

/// Where frames come from.
pub(super) struct Source {
    pub(super) cell: Option<Arc<Cell>>,
    pub(super) origin: Origin,
    /// Bytes of a frame that is not complete.
    rest: Vec<u8>,
    /// Whether its first frame came, and the number of the recording there.
    pub(super) begun: bool,
    number: u64,
    pub(super) end: Option<End>,
}

impl Source {
    pub(super) fn new(cell: Option<Arc<Cell>>, origin: Origin) -> Self {
        Self { cell, origin, rest: Vec::new(), begun: false, number: 0, end: None }
    }

    /// Takes bytes of its stream; the frames that become of them.
    pub(super) fn take(&mut self, bytes: &[u8], merger: &mut Merger) -> Vec<u8> {
        self.rest.extend_from_slice(bytes);
        let (mut merged, mut at) = (Vec::new(), 0);
        loop {
            match Frame::first(&self.rest[at..]) {
                Ok(Some((frame, length))) => {
                    match &frame {
                        Frame::Start(start) => (self.begun, self.number) = (true, start.recording),
                        Frame::End(end) => self.end = Some(end.clone()),
                        _ => {}
                    }
                    merger.take(self.origin, frame, &mut merged);
                    at += length;
                }
                Ok(None) => break,
                Err(error) => {
                    tracing::error!("a recording of a cell cannot be read: {error}");
                    at = self.rest.len();
                    break;
                }
            }
        }
        self.rest.drain(..at);
        merged
    }

    pub(super) async fn ask_to_end(&self) {
        let Some(cell) = self.cell.as_ref().filter(|_| self.begun) else { return };
        let number = self.number.to_string();
        if let Err(error) = cell.ask(&routes::end_recording(&number)).await {
            tracing::debug!("cell {}: the recording there is over: {error}", cell.name());
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use genom_protocol::frames::{Channel, Sample};

    use super::*;

    #[test]
    fn frames_survive_any_cut() {
        let channel = Channel {
            channel: 7,
            topic: "/far/pose".to_owned(),
            encoding: String::new(),
            schema: String::new(),
            definition: String::new(),
            metadata: BTreeMap::new(),
        };
        let mut bytes = Vec::new();
        Frame::Channel(channel).append(&mut bytes);
        Frame::Sample(Sample { channel: 7, number: 0, date: 0, message: &[9; 40] })
            .append(&mut bytes);
        for cut in 0..=bytes.len() {
            let (mut source, mut merger) =
                (Source::new(None, Origin { key: 1, rank: 1 }), Merger::default());
            let mut out = source.take(&bytes[..cut], &mut merger);
            out.extend(source.take(&bytes[cut..], &mut merger));
            let (first, length) = Frame::first(&out).unwrap().unwrap();
            assert!(matches!(first, Frame::Channel(_)), "{cut}");
            let (next, rest) = Frame::first(&out[length..]).unwrap().unwrap();
            assert!(matches!(next, Frame::Sample(_)) && length + rest == out.len(), "{cut}");
        }
    }
}
