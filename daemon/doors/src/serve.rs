//! Serves connections of the listeners: limits, timeouts, and an orderly end.

use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use axum::Router;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

use crate::access::Peer;
use crate::guests::{Guest, Guests, Reach};
use crate::listen::{Kind, Listener, Stream};
use crate::stall::Unstalled;

/// Timeout for the head of a request, and for the TLS handshake.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);

/// How long replies under way may take after the service ended.
const LAST_REPLIES: Duration = Duration::from_secs(2);

/// A listener, and the service behind it.
#[derive(Debug)]
pub struct Entrance {
    /// Where peers connect.
    pub listener: Listener,
    /// The service, behind its door ([`guard`](crate::guard::guard)).
    pub router: Router,
}

/// Limits of each listener.
#[derive(Clone, Copy, Debug)]
pub struct Most {
    /// Connections; further peers wait in the kernel's queue.
    pub connections: usize,
    /// Requests under way with one token; further ones are refused.
    pub per_token: usize,
}

impl Default for Most {
    fn default() -> Self {
        Self { connections: 256, per_token: 64 }
    }
}

/// Serves until `closed` is cancelled, then finishes the replies under way, within 2 s.
pub async fn serve(entrances: Vec<Entrance>, most: Most, closed: CancellationToken) {
    let serving = entrances
        .into_iter()
        .map(|entrance| tokio::spawn(serve_one(entrance, most, closed.clone())));
    for one in serving.collect::<Vec<_>>() {
        if let Err(error) = one.await {
            tracing::error!("a listener ended badly: {error}");
        }
    }
}

async fn serve_one(entrance: Entrance, most: Most, closed: CancellationToken) {
    let reach = match entrance.listener.kind {
        Kind::Unix(_) => Reach::Owner,
        Kind::Tcp(..) => Reach::All,
    };
    // Limits are per listener: exhausting one does not affect the others.
    let guests = Guests::new(most.connections, most.per_token, reach);
    let mut connections = JoinSet::new();
    loop {
        // Without room there is no `accept`: further peers wait in the kernel's queue.
        tokio::select! {
            () = guests.room() => {}
            () = closed.cancelled() => break,
        }
        tokio::select! {
            accepted = entrance.listener.accept() => match accepted {
                Ok(stream) => {
                    let (router, closed) = (entrance.router.clone(), closed.clone());
                    let guest = guests.enter();
                    connections.spawn(async move {
                        let leave = guest.leave().clone();
                        tokio::select! {
                            () = receive(stream, router, guest, closed) => {}
                            () = leave.cancelled() => {
                                tracing::debug!("a connection without a token made room");
                            }
                        }
                    });
                }
                Err(error) => pause_after(&error).await,
            },
            () = closed.cancelled() => break,
        }
        while connections.try_join_next().is_some() {}
    }
    let all = async { while connections.join_next().await.is_some() {} };
    // A peer that does not read its reply must not keep the daemon running.
    let _ = timeout(LAST_REPLIES, all).await;
}

/// The process has probably run out of descriptors: trying again at once would occupy a processor.
async fn pause_after(error: &io::Error) {
    tracing::warn!("a connection could not be accepted: {error}");
    tokio::time::sleep(Duration::from_millis(100)).await;
}

async fn receive(stream: Stream, router: Router, guest: Guest, closed: CancellationToken) {
    match stream {
        Stream::Unix(stream) => talk(stream, router, guest, None, closed).await,
        Stream::Tcp(stream, peer, None) => talk(stream, router, guest, Some(peer), closed).await,
        Stream::Tcp(stream, peer, Some(tls)) => {
            match timeout(HEAD_TIMEOUT, tls.accept(stream)).await {
                Ok(Ok(stream)) => talk(stream, router, guest, Some(peer), closed).await,
                Ok(Err(error)) => tracing::debug!("a TLS handshake with {peer} failed: {error}"),
                Err(_) => tracing::debug!("a TLS handshake with {peer} took too long"),
            }
        }
    }
}

async fn talk<S>(
    stream: S,
    router: Router,
    guest: Guest,
    peer: Option<SocketAddr>,
    closed: CancellationToken,
) where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let routes = TowerToHyperService::new(router);
    let service = service_fn(move |mut request: Request<Incoming>| {
        request.extensions_mut().insert(guest.clone());
        if let Some(peer) = peer {
            request.extensions_mut().insert(Peer(peer));
        }
        routes.call(request)
    });
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .serve_connection(TokioIo::new(Unstalled::new(stream)), service)
        .with_upgrades();
    tokio::pin!(connection);
    let ended = tokio::select! {
        ended = connection.as_mut() => ended,
        () = closed.cancelled() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = ended {
        // Peers may send invalid data or disconnect at any time: not a failure of the daemon.
        tracing::debug!("a connection ended early: {error}");
    }
}
