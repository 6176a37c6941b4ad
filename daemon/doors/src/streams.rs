//! Server-sent events: a limited number of streams, which end when the service ends.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::http::{HeaderMap, StatusCode};
use axum::response::sse::{Event, KeepAlive, KeepAliveStream, Sse};
use genom_protocol::Code;
use genom_protocol::sse::LAST_EVENT_ID;
use tokio::sync::mpsc;
use tokio_stream::wrappers::ReceiverStream;
use tokio_util::sync::CancellationToken;

use crate::error::RpcError;
use crate::holder::Holder;
use crate::slots::{Full, Slot, Slots};

/// A stream of events, as the response of a handler.
pub type Events = Sse<KeepAliveStream<ReceiverStream<Result<Event, Infallible>>>>;

/// How long a reader may read nothing before its stream ends.
const SLOWEST_READER: Duration = Duration::from_secs(10);

/// Interval at which a stream without events sends a comment. A reader that receives nothing for
/// longer knows that the service is gone or hangs.
const SIGN_OF_LIFE: Duration = Duration::from_secs(5);

/// The number of the last event that a reconnecting reader received (`Last-Event-ID`).
pub fn last_heard(headers: &HeaderMap) -> Option<u64> {
    headers.get(LAST_EVENT_ID)?.to_str().ok()?.parse().ok()
}

/// The writing end of a stream.
#[derive(Debug)]
pub struct Writer(mpsc::Sender<Result<Event, Infallible>>);

impl Writer {
    /// Sends an event; `false` if the reader is gone or does not read.
    pub async fn send(&self, event: Event) -> bool {
        self.0.send_timeout(Ok(event), SLOWEST_READER).await.is_ok()
    }

    /// Whether an event can be sent without waiting for the reader. A writer that has something
    /// newer next time leaves this out instead.
    #[must_use]
    pub fn has_room(&self) -> bool {
        self.0.capacity() > 0
    }

    /// Waits until the reader is gone.
    pub async fn closed(&self) {
        self.0.closed().await;
    }
}

/// The streams of a service; clones share the limits.
#[derive(Clone, Debug)]
pub struct Streams {
    slots: Arc<Slots>,
    closed: CancellationToken,
}

impl Streams {
    /// Allows `most` streams of the owner, and as many of all others together, of which each can
    /// have `each`. All streams end when `closed` is cancelled.
    #[must_use]
    pub fn new(most: usize, each: usize, closed: CancellationToken) -> Self {
        Self { slots: Slots::new(most, each), closed }
    }

    /// Takes a slot for a stream.
    ///
    /// # Errors
    /// Too many streams are open.
    pub fn slot(&self, holder: &Holder) -> Result<Slot, RpcError> {
        self.slots.take(holder.share.clone()).map_err(|full| {
            let (open, key) = match full {
                Full::All(most) => (format!("{most} streams"), "rpc.max_streams"),
                Full::Share(most) => {
                    (format!("{most} streams of this token"), "rpc.max_streams_per_token")
                }
            };
            let message = format!("{open} are open already");
            RpcError::new(StatusCode::SERVICE_UNAVAILABLE, Code::TooManyStreams, message)
                .help(format!("close one, or raise {key} in the daemon's configuration"))
        })
    }

    /// Opens a stream that `feed` writes, until it returns or the service ends.
    ///
    /// # Errors
    /// Too many streams are open.
    pub fn open<F, R>(&self, holder: &Holder, feed: F) -> Result<Events, RpcError>
    where
        F: FnOnce(Writer) -> R,
        R: Future<Output = ()> + Send + 'static,
    {
        let slot = self.slot(holder)?;
        let (sender, receiver) = mpsc::channel(8);
        let feeding = feed(Writer(sender.clone()));
        let closed = self.closed.clone();
        tokio::spawn(async move {
            feed_until(closed, feeding, &sender).await;
            drop(slot);
        });
        let events = Sse::new(ReceiverStream::new(receiver));
        Ok(events.keep_alive(KeepAlive::new().interval(SIGN_OF_LIFE)))
    }
}

/// Feeds a stream until the service ends. Events that are queued by then are still sent.
async fn feed_until<T>(
    closed: CancellationToken,
    feeding: impl Future<Output = ()>,
    sent: &mpsc::Sender<T>,
) {
    tokio::pin!(feeding);
    tokio::select! {
        () = feeding.as_mut() => return,
        () = closed.cancelled() => {}
    }
    loop {
        // Sends available events, as far as there is room.
        tokio::select! {
            biased;
            () = feeding.as_mut() => return,
            () = std::future::ready(()) => {}
        }
        if sent.capacity() == sent.max_capacity() {
            return;
        }
        // Waits until the reader has taken everything or is gone; at the end of the service,
        // connections have a limited time for this.
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

    /// What a reader receives of a stream that has twenty numbers queued when the service ends.
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
        let closed = CancellationToken::new();
        closed.cancel();
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
        let closed = CancellationToken::new();
        closed.cancel();
        feed_until(closed, feeding, &sender).await;
    }
}
