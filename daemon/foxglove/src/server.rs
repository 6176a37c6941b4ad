//! Where clients connect.

use std::sync::Arc;

use axum::Router;
use axum::routing::get;
use genom_configuration::{FoxgloveSection, RpcSettings};
use genom_doors::{
    Certificates, Entrance, Keep, ListenError, Listener, TlsError, Tokens, acceptor,
};
use tokio_util::sync::CancellationToken;

use crate::hub::Hub;
use crate::inside::Inside;
use crate::terms::Terms;
use crate::{keeper, upgrade};

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
pub struct Foxglove(Arc<Terms>);

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
        let terms = Terms::new(section, address, tokens, rpc.max_body, closed);
        Ok(Some((Self(Arc::new(terms)), listener)))
    }

    /// What is behind its address. `api` is the control plane, behind
    /// [`Door::proved`](genom_doors::Door::proved); `name` is that of the daemon. To be called in a
    /// runtime.
    pub fn entrance(&self, listener: Listener, api: Router, name: Option<&str>) -> Entrance {
        let hub = Hub::new(Inside::new(api), name);
        tokio::spawn(keeper::keep(Arc::clone(&hub), self.0.closed.clone()));
        let state = upgrade::State { terms: Arc::clone(&self.0), hub };
        let router = Router::new().route("/", get(upgrade::open)).with_state(state);
        Entrance { listener, router }
    }
}
