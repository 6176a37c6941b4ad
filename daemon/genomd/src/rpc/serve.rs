//! Serves connections of the listeners: limits, time-outs, and an orderly end.

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, UnixListener};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::JoinSet;

use crate::flag::Flag;

/// A peer that sends half a request head is given up after this.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);

/// How long replies under way may take once the daemon has stopped.
const LAST_REPLIES: Duration = Duration::from_secs(2);

/// Serves until `closed` is raised, then lets the replies under way finish.
pub(crate) async fn serve(
    unix: &UnixListener,
    tcp: Option<TcpListener>,
    router: Router,
    max_connections: usize,
    closed: Flag,
) {
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
            accepted = unix.accept() => match accepted {
                Ok((stream, _)) => {
                    connections.spawn(serve_one(stream, router.clone(), slot, closed.clone()));
                }
                Err(error) => pause_after(&error).await,
            },
            accepted = accept(tcp.as_ref()) => match accepted {
                Ok(stream) => {
                    connections.spawn(serve_one(stream, router.clone(), slot, closed.clone()));
                }
                Err(error) => pause_after(&error).await,
            },
            () = closed.raised() => break,
        }
        while connections.try_join_next().is_some() {}
    }
    let all = async { while connections.join_next().await.is_some() {} };
    // A peer that does not read its reply must not keep the daemon alive.
    let _ = tokio::time::timeout(LAST_REPLIES, all).await;
}

async fn accept(tcp: Option<&TcpListener>) -> std::io::Result<tokio::net::TcpStream> {
    match tcp {
        Some(listener) => listener.accept().await.map(|(stream, _)| stream),
        None => std::future::pending().await,
    }
}

/// Out of descriptors, most likely: accepting at once again would only burn a core.
async fn pause_after(error: &std::io::Error) {
    tracing::warn!("a connection could not be accepted: {error}");
    tokio::time::sleep(Duration::from_millis(100)).await;
}

async fn serve_one<S>(stream: S, router: Router, _slot: OwnedSemaphorePermit, closed: Flag)
where
    S: AsyncRead + AsyncWrite + Unpin + Send + 'static,
{
    let connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIMEOUT)
        .serve_connection(TokioIo::new(stream), TowerToHyperService::new(router));
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
