//! Server-sent events: a limited number of streams, closed when the daemon stops.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, Sse};
use genom_protocol::Code;
use genom_supervisor::flag::Flag;
use tokio::sync::mpsc;
use tokio_stream::Stream;
use tokio_stream::wrappers::ReceiverStream;

use crate::daemon::Daemon;
use crate::rpc::error::RpcError;
use crate::rpc::holder::Holder;
use crate::slots::{Full, Slot};

/// What a stream sends.
pub(super) type Events = ReceiverStream<Result<Event, Infallible>>;

/// How long a reader may take nothing before its stream ends.
const SLOWEST_READER: Duration = Duration::from_secs(10);

/// How often a stream without events sends a comment: a reader that gets nothing for longer knows
/// that the daemon is gone or hangs.
const SIGN_OF_LIFE: Duration = Duration::from_secs(5);

/// The number that a reader who comes back heard last (`Last-Event-ID`).
pub(super) fn last_heard(headers: &HeaderMap) -> Option<u64> {
    headers.get("last-event-id")?.to_str().ok()?.parse().ok()
}

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

/// A limit that is reached, for messages.
pub(super) fn limit(full: Full) -> String {
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
        let message = format!("{} streams are open already", limit(full));
        let message = message.replace(" of this token streams", " streams of this token");
        RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::TooManyStreams, message)
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
    let feeding = feed(Writer(sender.clone()));
    let closed = daemon.closed.clone();
    tokio::spawn(async move {
        feed_until(closed, feeding, &sender).await;
        drop(slot);
    });
    let events: Events = ReceiverStream::new(receiver);
    Ok(Sse::new(events).keep_alive(KeepAlive::new().interval(SIGN_OF_LIFE)))
}

/// Feeds a stream until the daemon stops. Events that are there by then are still sent.
async fn feed_until<T>(closed: Flag, feeding: impl Future<Output = ()>, sent: &mpsc::Sender<T>) {
    tokio::pin!(feeding);
    tokio::select! {
        () = feeding.as_mut() => return,
        () = closed.raised() => {}
    }
    loop {
        // Sends what is there, as far as there is room.
        tokio::select! {
            biased;
            () = feeding.as_mut() => return,
            () = std::future::ready(()) => {}
        }
        if sent.capacity() == sent.max_capacity() {
            return;
        }
        // Until the reader has taken all of it, or is gone: the end of the daemon waits for its
        // connections for a limited time only.
        tokio::select! {
            () = feeding.as_mut() => return,
            () = sent.closed() => return,
            room = sent.reserve_many(sent.max_capacity()) => drop(room),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What a reader gets of a stream that has twenty numbers to say when the daemon has stopped,
    /// and then nothing.
    #[tokio::test]
    async fn what_was_told_before_the_end_is_heard() {
        let (sender, mut receiver) = mpsc::channel(8);
        let writer = sender.clone();
        let feeding = async move {
            for number in 0..20 {
                writer.send(number).await.unwrap();
            }
            std::future::pending::<()>().await;
        };
        let closed = Flag::new();
        closed.raise();
        let feeding = tokio::spawn(async move { feed_until(closed, feeding, &sender).await });
        let mut heard = Vec::new();
        while let Some(number) = receiver.recv().await {
            heard.push(number);
        }
        assert_eq!(heard, (0..20).collect::<Vec<_>>());
        feeding.await.unwrap();
    }

    #[tokio::test]
    async fn a_stream_ends_with_its_reader() {
        let (sender, receiver) = mpsc::channel(1);
        let writer = sender.clone();
        let feeding = async move {
            while writer.send(0).await.is_ok() {}
            std::future::pending::<()>().await;
        };
        drop(receiver);
        let closed = Flag::new();
        closed.raise();
        feed_until(closed, feeding, &sender).await;
    }
}
