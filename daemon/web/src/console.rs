//! What all requests to the console share.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::Request;
use genom_configuration::{RpcSettings, WebSection};
use genom_doors::{
    Certificates, Holder, Keep, ListenError, Listener, Peer, Seldom, Streams, TlsError, Tokens,
    acceptor,
};
use genom_protocol::Right;
use tokio_util::sync::CancellationToken;

use crate::links::Links;
use crate::secret::Secret;
use crate::sessions::Sessions;
use crate::site::Site;
use crate::visitor::Visitor;

/// Streams open at once, of all sessions together and of one.
const STREAMS: (usize, usize) = (128, 16);

/// Why the console cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Certificates or keys cannot be used.
    #[error(transparent)]
    Tls(#[from] TlsError),
    /// The address cannot be listened on.
    #[error("web console: {0}")]
    Listen(#[from] ListenError),
}

/// A console; clones are the same one.
#[derive(Clone, Debug)]
pub struct Console(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    address: SocketAddr,
    cookie: String,
    site: Site,
    tokens: Arc<Tokens>,
    sessions: Sessions,
    links: Links,
    streams: Streams,
    refused: Seldom,
}

impl Console {
    /// Opens the console where the configuration says, with TLS if others can reach it; `None` if
    /// the configuration has none. Sessions are kept beside the socket of the control plane.
    /// Streams end when `closed` is cancelled.
    ///
    /// # Errors
    /// Certificates cannot be used, or the address cannot be listened on.
    pub async fn open(
        section: &WebSection,
        rpc: &RpcSettings,
        tokens: &Arc<Tokens>,
        keep: Keep,
        closed: &CancellationToken,
    ) -> Result<Option<(Self, Listener)>, OpenError> {
        let Some(address) = section.listen else { return Ok(None) };
        let tls = rpc.tls.as_ref().filter(|_| !address.ip().is_loopback());
        let files = tls.map(|tls| Certificates { cert: &tls.cert, key: &tls.key, client_ca: None });
        let tls = files.map(acceptor).transpose()?;
        let scheme = if tls.is_some() { "https" } else { "http" };
        let lifetime = Duration::from_secs_f64(section.session_time);
        let kept = Arc::clone(tokens);
        let sessions = Sessions::new(section.max_sessions, lifetime, kept, &rpc.socket);
        // Pages that are open ask where the console of the daemon before this one was.
        let again = sessions.last_address();
        let again = again.filter(|last| address.port() == 0 && last.ip() == address.ip());
        let opened = match again {
            Some(again) => Listener::tcp(again, tls.clone(), keep).await.ok(),
            None => None,
        };
        let (listener, address) = match opened {
            Some(opened) => opened,
            None => Listener::tcp(address, tls, keep).await?,
        };
        sessions.set_address(address);
        let console = Self(Arc::new(Inner {
            // Cookies do not depend on the port: each console has one of its own name.
            cookie: format!("genomd-{}", address.port()),
            site: Site { scheme, hosts: section.hosts.clone() },
            links: Links::new(Duration::from_secs_f64(section.link_time)),
            streams: Streams::new(STREAMS.0, STREAMS.1, closed.clone()),
            refused: Seldom::default(),
            tokens: Arc::clone(tokens),
            address,
            sessions,
        }));
        tracing::info!("web console on {}; `genomctl web` signs in", console.url());
        Ok(Some((console, listener)))
    }

    /// Its address, for browsers on this machine if it is on all addresses.
    pub(crate) fn url(&self) -> String {
        let Inner { address, site, .. } = &*self.0;
        let (scheme, port) = (site.scheme, address.port());
        match (address.ip().is_unspecified(), site.hosts.first()) {
            (true, Some(host)) => format!("{scheme}://{host}:{port}"),
            (true, None) => format!("{scheme}://localhost:{port}"),
            (false, _) => format!("{scheme}://{address}"),
        }
    }

    /// Name of its cookie.
    pub(crate) fn cookie(&self) -> &str {
        &self.0.cookie
    }

    /// A `Set-Cookie` header that lasts for this time.
    pub(crate) fn set_cookie(&self, secret: &str, seconds: u64) -> String {
        let secure = if self.0.site.scheme == "https" { "; Secure" } else { "" };
        let name = self.cookie();
        format!("{name}={secret}; HttpOnly; SameSite=Strict; Path=/; Max-Age={seconds}{secure}")
    }

    pub(crate) fn site(&self) -> &Site {
        &self.0.site
    }

    pub(crate) fn tokens(&self) -> &Tokens {
        &self.0.tokens
    }

    pub(crate) fn sessions(&self) -> &Sessions {
        &self.0.sessions
    }

    pub(crate) fn links(&self) -> &Links {
        &self.0.links
    }

    pub(crate) fn streams(&self) -> &Streams {
        &self.0.streams
    }

    /// The holder of a session.
    pub(crate) fn holder(&self, secret: &Secret) -> Option<Holder> {
        self.0.sessions.holder(&secret.0)
    }

    /// Whose session this is, with these rights instead.
    pub(crate) fn visitor(&self, secret: &Secret, rights: Option<Vec<Right>>) -> Option<Visitor> {
        self.0.sessions.visitor(&secret.0, rights)
    }

    /// Logs a request that was refused, with its sender and never with a secret.
    pub(crate) fn refuse(&self, request: &Request, why: &str) {
        let from = request.extensions().get::<Peer>();
        let from = from.map_or_else(String::new, |Peer(peer)| format!(" of {}", peer.ip()));
        let path = request.uri().path();
        let path = path.get(..100).unwrap_or(path);
        let method = request.method();
        self.0.refused.tell(format!("{from}{why}"), |more| {
            tracing::warn!("web console: refused {method} {path}{from}: {why}{more}");
        });
    }
}
