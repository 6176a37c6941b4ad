//! Server-sent events: a limited number of streams, closed when the daemon stops.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::http::StatusCode;
use axum::response::sse::{Event, KeepAlive, Sse};
use tokio::sync::{OwnedSemaphorePermit, mpsc};
use tokio_stream::Stream;
use tokio_stream::wrappers::ReceiverStream;

use crate::daemon::Daemon;
use crate::rpc::error::RpcError;

/// What a stream sends.
pub(super) type Events = ReceiverStream<Result<Event, Infallible>>;

/// A reader that takes nothing for so long is given up.
const SLOWEST_READER: Duration = Duration::from_secs(10);

/// The writing end of a stream.
pub(super) struct Writer(mpsc::Sender<Result<Event, Infallible>>);

impl Writer {
    /// Sends an event; `false` when the reader is gone or does not read.
    pub(super) async fn send(&self, event: Event) -> bool {
        self.0.send_timeout(Ok(event), SLOWEST_READER).await.is_ok()
    }

    /// Waits until the reader is gone.
    pub(super) async fn closed(&self) {
        self.0.closed().await;
    }
}

/// Takes one of the slots for open streams; refused when too many are open.
pub(super) fn slot(daemon: &Daemon) -> Result<OwnedSemaphorePermit, RpcError> {
    Arc::clone(&daemon.streams).try_acquire_owned().map_err(|_| {
        let most = daemon.settings.rpc.max_streams;
        let message = format!("{most} streams are open already");
        RpcError::new(StatusCode::SERVICE_UNAVAILABLE, "too_many_streams", message)
            .help("close one, or raise rpc.max_streams in the daemon's configuration")
    })
}

/// Opens a stream that `feed` writes; refused when too many are open.
pub(super) fn open<F, R>(
    daemon: &Arc<Daemon>,
    feed: F,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>> + use<F, R>>, RpcError>
where
    F: FnOnce(Writer) -> R,
    R: Future<Output = ()> + Send + 'static,
{
    let slot = slot(daemon)?;
    let (sender, receiver) = mpsc::channel(8);
    let feeding = feed(Writer(sender));
    let closed = daemon.closed.clone();
    tokio::spawn(async move {
        tokio::select! {
            () = feeding => {}
            () = closed.raised() => {}
        }
        drop(slot);
    });
    let events: Events = ReceiverStream::new(receiver);
    Ok(Sse::new(events).keep_alive(KeepAlive::new()))
}
