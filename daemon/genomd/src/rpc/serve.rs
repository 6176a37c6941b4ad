//! Serves connections of the listeners: limits, time-outs, and an orderly end.

use std::io;
use std::net::SocketAddr;
use std::os::fd::OwnedFd;
use std::time::Duration;

use axum::Router;
use genom_host::{keep_from_children, keep_off};
use genom_supervisor::flag::Flag;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service as _, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream, UnixListener, UnixStream};
use tokio::task::JoinSet;
use tokio::time::timeout;
use tokio_rustls::TlsAcceptor;

use crate::rpc::access::Peer;
use crate::rpc::guests::{Guest, Guests, Reach};
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
enum Stream {
    Unix(UnixStream),
    Tcp(TcpStream, SocketAddr, Option<TlsAcceptor>),
}

/// A listener, and what it serves.
pub(crate) struct Entrance {
    pub(crate) listener: Listener,
    pub(crate) router: Router,
}

/// How many may come in at a time, at each listener.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Most {
    pub(crate) connections: usize,
    /// With a request under way, of one token.
    pub(crate) per_token: usize,
}

/// Serves until `closed` is raised, then lets the replies under way finish.
pub(crate) async fn serve(entrances: Vec<Entrance>, most: Most, closed: Flag) {
    let serving = entrances
        .into_iter()
        .map(|entrance| tokio::spawn(serve_one(entrance, most, closed.clone())));
    for one in serving.collect::<Vec<_>>() {
        if let Err(error) = one.await {
            tracing::error!("a listener ended badly: {error}");
        }
    }
}

async fn serve_one(entrance: Entrance, most: Most, closed: Flag) {
    let reach = match &entrance.listener {
        Listener::Unix(listener) => {
            keep_from_children(listener);
            Reach::Owner
        }
        Listener::Tcp(listener, _) => {
            keep_from_children(listener);
            Reach::All
        }
    };
    // Each listener has its own: who fills one does not lock out the other.
    let guests = Guests::new(most.connections, most.per_token, reach);
    let mut connections = JoinSet::new();
    loop {
        // No room, no accept: further peers wait in the kernel's queue.
        tokio::select! {
            () = guests.room() => {}
            () = closed.raised() => break,
        }
        tokio::select! {
            accepted = accept(&entrance.listener) => match accepted {
                Ok(stream) => {
                    let (router, closed) = (entrance.router.clone(), closed.clone());
                    let guest = guests.enter();
                    connections.spawn(async move {
                        let leave = guest.leave().clone();
                        tokio::select! {
                            () = receive(stream, router, guest, closed) => {}
                            () = leave.raised() => {
                                tracing::debug!("a connection without a token made room");
                            }
                        }
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

async fn accept(listener: &Listener) -> io::Result<Stream> {
    match listener {
        Listener::Unix(listener) => {
            let stream = own(listener.accept().await?.0.into_std()?.into())?;
            Ok(Stream::Unix(UnixStream::from_std(stream.into())?))
        }
        Listener::Tcp(listener, tls) => {
            let (stream, peer) = listener.accept().await?;
            let stream = own(stream.into_std()?.into())?;
            Ok(Stream::Tcp(TcpStream::from_std(stream.into())?, peer, tls.clone()))
        }
    }
}

/// A connection that codels do not get at: neither what they print, nor children that they fork.
fn own(connection: OwnedFd) -> io::Result<OwnedFd> {
    let connection = keep_off(connection)?;
    keep_from_children(&connection);
    Ok(connection)
}

/// The process has probably no descriptors left: trying again at once would keep a processor.
async fn pause_after(error: &io::Error) {
    tracing::warn!("a connection could not be accepted: {error}");
    tokio::time::sleep(Duration::from_millis(100)).await;
}

async fn receive(stream: Stream, router: Router, guest: Guest, closed: Flag) {
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

async fn talk<S>(stream: S, router: Router, guest: Guest, peer: Option<SocketAddr>, closed: Flag)
where
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
        .serve_connection(TokioIo::new(Unstalled::new(stream)), service);
    tokio::pin!(connection);
    let ended = tokio::select! {
        ended = connection.as_mut() => ended,
        () = closed.raised() => {
            connection.as_mut().graceful_shutdown();
            connection.await
        }
    };
    if let Err(error) = ended {
        // Peers may send nonsense, or go away in the middle: no fault of the daemon.
        tracing::debug!("a connection ended early: {error}");
    }
}
