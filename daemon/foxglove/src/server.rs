//! What all clients share, and where they connect.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use axum::Router;
use axum::extract::Request;
use axum::routing::get;
use genom_configuration::{FoxgloveSection, RpcSettings};
use genom_doors::{
    Certificates, Entrance, Keep, ListenError, Listener, Peer, Seldom, TlsError, Tokens, acceptor,
};
use tokio_util::sync::CancellationToken;

use crate::hub::Hub;
use crate::inside::Inside;
use crate::upgrade;

/// Why the source cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Certificates or keys cannot be used.
    #[error(transparent)]
    Tls(#[from] TlsError),
    /// The address cannot be listened on.
    #[error("foxglove: {0}")]
    Listen(#[from] ListenError),
}

/// A live source for Foxglove; clones are the same one.
#[derive(Clone, Debug)]
pub struct Foxglove(pub(crate) Arc<Inner>);

#[derive(Debug)]
pub(crate) struct Inner {
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
pub(crate) struct Seat(Arc<Inner>);

impl Foxglove {
    /// Opens it where the configuration says, with TLS if others can reach it; `None` if the
    /// configuration has none. Clients are sent away when `closed` is cancelled.
    ///
    /// # Errors
    /// Certificates cannot be used, or the address cannot be listened on.
    pub async fn open(
        section: &FoxgloveSection,
        rpc: &RpcSettings,
        tokens: &Arc<Tokens>,
        keep: Keep,
        closed: &CancellationToken,
    ) -> Result<Option<(Self, Listener)>, OpenError> {
        let Some(address) = section.listen else { return Ok(None) };
        let tls = rpc.tls.as_ref().filter(|_| !address.ip().is_loopback());
        let files = tls.map(|tls| Certificates { cert: &tls.cert, key: &tls.key, client_ca: None });
        let tls = files.map(acceptor).transpose()?;
        let scheme = if tls.is_some() { "wss" } else { "ws" };
        let (listener, address) = Listener::tcp(address, tls, keep).await?;
        tracing::info!("foxglove on {scheme}://{address}");
        let foxglove = Self(Arc::new(Inner {
            section: section.clone(),
            address,
            tokens: Arc::clone(tokens),
            longest: rpc.max_body,
            closed: closed.clone(),
            refused: Seldom::default(),
            clients: AtomicUsize::new(0),
        }));
        Ok(Some((foxglove, listener)))
    }

    /// What is behind its address. `api` is the control plane, behind
    /// [`Door::proved`](genom_doors::Door::proved); `name` is that of the daemon. To be called in a
    /// runtime.
    pub fn entrance(&self, listener: Listener, api: Router, name: Option<&str>) -> Entrance {
        let hub = Hub::new(Inside::new(api), name, self.0.closed.clone());
        tokio::spawn(Arc::clone(&hub).keep());
        let state = upgrade::State { foxglove: self.clone(), hub };
        let router = Router::new().route("/", get(upgrade::open)).with_state(state);
        Entrance { listener, router }
    }

    /// A place for one more client, unless there are as many as there may be.
    pub(crate) fn seat(&self) -> Option<Seat> {
        let most = self.0.section.max_clients;
        let more = |there: usize| (there < most).then_some(there + 1);
        let taken = self.0.clients.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more);
        taken.is_ok().then(|| Seat(Arc::clone(&self.0)))
    }

    /// Logs a request that was refused, with its sender and never with a token.
    pub(crate) fn refuse(&self, request: &Request, why: &str) {
        let from = request.extensions().get::<Peer>();
        let from = from.map_or_else(String::new, |Peer(peer)| format!(" of {}", peer.ip()));
        self.0.refused.tell(format!("{from}{why}"), |more| {
            tracing::warn!("foxglove: refused a client{from}: {why}{more}");
        });
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        self.0.clients.fetch_sub(1, Ordering::Relaxed);
    }
}
