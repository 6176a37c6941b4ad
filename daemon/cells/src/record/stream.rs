//! The stream of a recording in a cell's present process.

use genom_protocol::sse::LAST_EVENT_ID;
use genom_protocol::{RecordingRequest, routes};
use genom_supervisor::recording::Apart;
use http_body_util::BodyExt as _;
use hyper::body::{Bytes, Incoming};

use crate::cell::Cell;
use crate::client::AskError;

/// Frames of a process, as they come.
pub(super) struct Stream(Incoming);

impl Stream {
    /// Begins a recording in a cell. What its process tells from now on is in it, as `apart` knows
    /// then.
    pub(super) async fn open(
        cell: &Cell,
        wanted: &RecordingRequest,
        apart: &Apart,
    ) -> Result<Self, AskError> {
        let process = cell.pid();
        let reply = cell.stream(&routes::record(), wanted).await?;
        let after = reply.headers().get(LAST_EVENT_ID).and_then(|value| value.to_str().ok());
        // A process of an older genomd does not say it: what it tells is recorded twice then.
        if let (Some(process), Some(after)) = (process, after.and_then(|text| text.parse().ok())) {
            apart.begins(cell.name(), process, after);
        }
        Ok(Self(reply.into_body()))
    }

    /// The next bytes; `None` at the end of the process, or of its recording.
    pub(super) async fn next(&mut self) -> Option<Bytes> {
        loop {
            if let Ok(bytes) = self.0.frame().await?.ok()?.into_data() {
                return Some(bytes);
            }
        }
    }
}
