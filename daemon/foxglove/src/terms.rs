//! On which terms clients are served: who may come, how many, with messages of which length.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use axum::extract::Request;
use genom_configuration::FoxgloveSection;
use genom_doors::{Peer, Seldom, Tokens};
use tokio_util::sync::CancellationToken;

/// What the configuration says, and how many clients there are.
#[derive(Debug)]
pub(crate) struct Terms {
    pub(crate) section: FoxgloveSection,
    pub(crate) address: SocketAddr,
    pub(crate) tokens: Arc<Tokens>,
    /// Longest message of a client, in bytes.
    pub(crate) longest: usize,
    pub(crate) closed: CancellationToken,
    refused: Seldom,
    clients: AtomicUsize,
}

/// A place among the clients; free again when dropped.
#[derive(Debug)]
pub(crate) struct Seat(Arc<Terms>);

impl Terms {
    /// For a source at this address, without clients. Those that come are sent away when `closed` is
    /// cancelled.
    pub(crate) fn new(
        section: &FoxgloveSection,
        address: SocketAddr,
        tokens: &Arc<Tokens>,
        longest: usize,
        closed: &CancellationToken,
    ) -> Self {
        Self {
            section: section.clone(),
            address,
            tokens: Arc::clone(tokens),
            longest,
            closed: closed.clone(),
            refused: Seldom::default(),
            clients: AtomicUsize::new(0),
        }
    }

    /// A place for one more client, unless there are as many as there may be.
    pub(crate) fn seat(self: &Arc<Self>) -> Option<Seat> {
        let most = self.section.max_clients;
        let more = |there: usize| (there < most).then_some(there + 1);
        let taken = self.clients.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more);
        taken.is_ok().then(|| Seat(Arc::clone(self)))
    }

    /// Logs a request that was refused, with its sender and never with a token.
    pub(crate) fn refuse(&self, request: &Request, why: &str) {
        let from = request.extensions().get::<Peer>();
        let from = from.map_or_else(String::new, |Peer(peer)| format!(" of {}", peer.ip()));
        self.refused.tell(format!("{from}{why}"), |more| {
            tracing::warn!("foxglove: refused a client{from}: {why}{more}");
        });
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.clients.fetch_sub(1, Ordering::Relaxed);
    }
}
