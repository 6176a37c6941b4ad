//! What the sending thread sends: samples of out ports, requests, replies, states of activities.

use std::sync::Arc;
use std::time::Duration;

use bytes::Bytes;
use genom_kit::lines::Lines;
use genom_kit::outlet::Outlet;
use genom_kit::sender::{self, Duty};
use zenoh::bytes::ZBytes;
use zenoh::{Session, Wait};
use zenoh_ext::AdvancedPublisher;

use super::attachment::Attachment;
use super::router::Router;

/// Data that jobs of the sending thread use.
pub(crate) struct Outgoing {
    pub(crate) session: Session,
    pub(crate) router: Arc<Router>,
}

impl Duty for Outgoing {
    type Line = Line;

    fn due(&mut self, _: &Lines<Line>) -> Option<Duration> {
        self.router.due(&self.session)
    }
}

/// Gives jobs to the sending thread.
pub(crate) type Orders = sender::Orders<Outgoing>;

/// A publisher that numbers its samples.
pub(crate) struct Numbered {
    pub(crate) publisher: AdvancedPublisher<'static>,
    /// Of the last sample.
    pub(crate) last: Attachment,
}

impl Numbered {
    /// Sends a message, header included.
    pub(crate) fn put(&mut self, message: impl Into<ZBytes>) -> zenoh::Result<()> {
        self.last.number += 1;
        self.publisher.put(message).attachment(&self.last.encode()[..]).wait()
    }
}

/// An out port as the sending thread sees it.
pub(crate) struct Line {
    pub(crate) publisher: Numbered,
    pub(crate) outlet: Arc<Outlet>,
}

impl sender::Line for Line {
    fn send(&mut self) -> bool {
        let Some(message) = self.outlet.take() else { return false };
        if let Err(error) = self.publisher.put(Bytes::from_owner(message)) {
            self.outlet.refuse();
            let key = self.publisher.publisher.key_expr();
            tracing::debug!(%error, %key, "zenoh refused a sample");
        }
        true
    }
}
