//! Serves connections of the listeners: limits, time-outs, and an orderly end.

use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use genom_host::{keep_from_children, keep_off};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream, UnixListener, UnixStream};
use tokio::sync::Semaphore;
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_rustls::TlsAcceptor;

use crate::flag::Flag;
use crate::rpc::stall::Unstalled;

/// A peer that sends half a request head, or half a handshake, is given up after this.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);

/// How long replies under way may take once the daemon has stopped.
const LAST_REPLIES: Duration = Duration::from_secs(2);

/// Where peers come from.
pub(crate) enum Listener {
    Unix(UnixListener),
    Tcp(TcpListener, Option<TlsAcceptor>),
}

/// A peer that was let in.
enum Peer {
    Unix(UnixStream),
    Tcp(TcpStream, Option<TlsAcceptor>),
}

/// A listener, and what it serves.
pub(crate) struct Entrance {
    pub(crate) listener: Listener,
    pub(crate) router: Router,
}

/// Serves until `closed` is raised, then lets the replies under way finish.
pub(crate) async fn serve(entrances: Vec<Entrance>, max_connections: usize, closed: Flag) {
    let serving = entrances
        .into_iter()
        .map(|entrance| tokio::spawn(serve_one(entrance, max_connections, closed.clone())));
    for one in serving.collect::<Vec<_>>() {
        if let Err(error) = one.await {
            tracing::error!("a listener ended badly: {error}");
        }
    }
}

async fn serve_one(entrance: Entrance, max_connections: usize, closed: Flag) {
    match &entrance.listener {
        Listener::Unix(listener) => keep_from_children(listener),
        Listener::Tcp(listener, _) => keep_from_children(listener),
    }
    // Each listener has its own: who fills one does not lock out the other.
    let slots = Arc::new(Semaphore::new(max_connections));
    let mut connections = JoinSet::new();
    loop {
        // No slot, no accept: further peers wait in the kernel's queue.
        let slot = tokio::select! {
            slot = Arc::clone(&slots).acquire_owned() => slot,
            () = closed.raised() => break,
        };
        let Ok(slot) = slot else { break };
        tokio::select! {
            accepted = accept(&entrance.listener) => match accepted {
                Ok(peer) => {
                    let (router, closed) = (entrance.router.clone(), closed.clone());
                    connections.spawn(async move {
                        receive(peer, router, closed).await;
                        drop(slot);
                    });
                }
                Err(error) => pause_after(&error).await,
            },
            () = closed.raised() => break,
        }
        while connections.try_join_next().is_some() {}
    }
    let all = async { while connections.join_next().await.is_some() {} };
    // A peer that does not read its reply must not keep the daemon alive.
    let _ = timeout(LAST_REPLIES, all).await;
}

async fn accept(listener: &Listener) -> io::Result<Peer> {
    match listener {
        Listener::Unix(listener) => {
            let stream = own(listener.accept().await?.0.into_std()?.into())?;
            Ok(Peer::Unix(UnixStream::from_std(stream.into())?))
        }
        Listener::Tcp(listener, tls) => {
            let stream = own(listener.accept().await?.0.into_std()?.into())?;
            Ok(Peer::Tcp(TcpStream::from_std(stream.into())?, tls.clone()))
        }
    }
}

/// A connection that codels do not get at: neither what they print, nor children that they fork.
fn own(connection: OwnedFd) -> io::Result<OwnedFd> {
    let connection = keep_off(connection)?;
    keep_from_children(&connection);
    Ok(connection)
}

/// Out of descriptors, most likely: accepting at once again would only burn a core.
async fn pause_after(error: &io::Error) {
    tracing::warn!("a connection could not be accepted: {error}");
    tokio::time::sleep(Duration::from_millis(100)).await;
}

async fn receive(peer: Peer, router: Router, closed: Flag) {
    match peer {
        Peer::Unix(stream) => talk(stream, router, closed).await,
        Peer::Tcp(stream, None) => talk(stream, router, closed).await,
        Peer::Tcp(stream, Some(tls)) => match timeout(HEAD_TIMEOUT, tls.accept(stream)).await {
            Ok(Ok(stream)) => talk(stream, router, closed).await,
            Ok(Err(error)) => tracing::debug!("a TLS handshake failed: {error}"),
            Err(_) => tracing::debug!("a TLS handshake took too long"),
        },
    }
}

async fn talk<S>(stream: S, router: Router, closed: Flag)
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .serve_connection(TokioIo::new(Unstalled::new(stream)), TowerToHyperService::new(router));
    tokio::pin!(connection);
    let ended = tokio::select! {
        ended = connection.as_mut() => ended,
        () = closed.raised() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = ended {
        // Peers send nonsense and go away in the middle: theirs to worry about.
        tracing::debug!("a connection ended early: {error}");
    }
}
