//! What the sending thread of a session sends: samples of out ports, replies, queries.

use std::sync::{Arc, Mutex, PoisonError};

use bytes::Bytes;
use genom_kit::outlet::Outlet;
use genom_kit::sender::{self, Duty};
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::{Session, Wait};

use crate::wire::Mark;

/// Data that jobs of the sending thread use.
pub(crate) struct Outgoing {
    pub(crate) session: Session,
}

impl Duty for Outgoing {
    type Line = Line;
}

/// Gives jobs to the sending thread.
pub(crate) type Orders = sender::Orders<Outgoing>;

/// An out port as the sending thread sees it.
pub(crate) struct Line {
    pub(crate) publisher: Publisher<'static>,
    pub(crate) outlet: Arc<Outlet>,
    pub(crate) last: Arc<LastValue>,
    /// Mark of the last sample sent.
    pub(crate) mark: Mark,
}

/// What late readers get: payload and attachment.
#[derive(Debug, Default)]
pub(crate) struct LastValue(Mutex<Option<(ZBytes, Mark)>>);

impl LastValue {
    pub(crate) fn get(&self) -> Option<(ZBytes, Mark)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn set(&self, payload: ZBytes, mark: Mark) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((payload, mark));
    }
}

impl sender::Line for Line {
    fn send(&mut self) -> bool {
        let Some(message) = self.outlet.take() else { return false };
        let payload = ZBytes::from(Bytes::from_owner(message));
        self.mark.number += 1;
        // Store the value for late readers before sending it, so that a reader that appears in
        // between gets it one way or the other.
        self.last.set(payload.clone(), self.mark);
        let put = self.publisher.put(payload).attachment(&self.mark.to_bytes()[..]);
        if let Err(error) = put.wait() {
            self.outlet.refuse();
            tracing::debug!(%error, key = %self.publisher.key_expr(), "zenoh refused a sample");
        }
        true
    }
}
