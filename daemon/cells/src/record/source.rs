//! A process whose frames are recorded.

use std::sync::Arc;

use genom_protocol::frames::{End, Frame};
use genom_protocol::routes;

use super::merger::Merger;
use crate::cell::Cell;

/// Where frames come from.
pub(super) struct Source {
    pub(super) cell: Option<Arc<Cell>>,
    /// By which the channels there are known.
    pub(super) key: usize,
    /// Its rank in the order of processes; the next process of a cell has the same.
    pub(super) process: usize,
    /// Bytes of a frame that is not complete.
    rest: Vec<u8>,
    /// Whether its first frame came, and the number of the recording there.
    pub(super) begun: bool,
    number: u64,
    pub(super) end: Option<End>,
}

impl Source {
    pub(super) fn new(cell: Option<Arc<Cell>>, key: usize, process: usize) -> Self {
        Self { cell, key, process, rest: Vec::new(), begun: false, number: 0, end: None }
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
                    merger.take(self, frame, &mut merged);
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
