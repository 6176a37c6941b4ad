//! Server-sent events: a limited number of streams, closed when the daemon stops.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::http::StatusCode;
use axum::response::sse::{Event, KeepAlive, Sse};
use tokio::sync::mpsc;
use tokio_stream::Stream;
use tokio_stream::wrappers::ReceiverStream;

use crate::daemon::Daemon;
use crate::rpc::error::RpcError;
use crate::rpc::holder::Holder;
use crate::slots::{Full, Slot};

/// What a stream sends.
pub(super) type Events = ReceiverStream<Result<Event, Infallible>>;

/// A reader that takes nothing for so long is given up.
const SLOWEST_READER: Duration = Duration::from_secs(10);

/// A stream with nothing to say shows that often that the daemon is alive: a reader that hears
/// nothing for longer knows that it is not.
const SIGN_OF_LIFE: Duration = Duration::from_secs(5);

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

/// How many there are, for messages.
pub(super) fn told(full: Full) -> String {
    match full {
        Full::All(most) => most.to_string(),
        Full::Share(most) => format!("{most} of this token"),
    }
}

/// Takes one of the slots for open streams; refused when too many are open.
pub(super) fn slot(daemon: &Daemon, holder: &Holder) -> Result<Slot, RpcError> {
    daemon.streams.take(holder.share.clone()).map_err(|full| {
        let key = match full {
            Full::All(_) => "rpc.max_streams",
            Full::Share(_) => "rpc.max_streams_per_token",
        };
        let message = format!("{} streams are open already", told(full));
        let message = message.replace(" of this token streams", " streams of this token");
        RpcError::new(StatusCode::SERVICE_UNAVAILABLE, "too_many_streams", message)
            .help(format!("close one, or raise {key} in the daemon's configuration"))
    })
}

/// Opens a stream that `feed` writes; refused when too many are open.
pub(super) fn open<F, R>(
    daemon: &Arc<Daemon>,
    holder: &Holder,
    feed: F,
) -> Result<Sse<impl Stream<Item = Result<Event, Infallible>> + use<F, R>>, RpcError>
where
    F: FnOnce(Writer) -> R,
    R: Future<Output = ()> + Send + 'static,
{
    let slot = slot(daemon, holder)?;
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
    Ok(Sse::new(events).keep_alive(KeepAlive::new().interval(SIGN_OF_LIFE)))
}
