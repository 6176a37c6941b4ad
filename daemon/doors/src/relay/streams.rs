//! Streams that clients of other daemons read piece by piece.
//!
//! A relay only transports questions and answers, so the client asks repeatedly for what has
//! arrived. It reads at its own pace; when it does not ask any more, for whatever reason, the
//! stream is closed.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::body::{Body, BodyDataStream};
use tokio::sync::{mpsc, oneshot};
use tokio::time::timeout;
use tokio_stream::StreamExt as _;

/// How long a question waits for data.
const PATIENCE: Duration = Duration::from_secs(2);

/// A stream is closed when it is not asked for this long (a lease); readers may pause for less.
const LEASE: Duration = Duration::from_secs(20);

/// An answer is sent when it has this many bytes.
const FULL: usize = 256 << 10;

/// A piece, and whether there may be more.
type Piece = (Vec<u8>, bool);

/// The open streams of a session, by number.
#[derive(Debug, Default)]
pub(super) struct Streams {
    open: Mutex<HashMap<u64, mpsc::Sender<oneshot::Sender<Piece>>>>,
}

impl Streams {
    fn lock(&self) -> MutexGuard<'_, HashMap<u64, mpsc::Sender<oneshot::Sender<Piece>>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a body to be read, under the number of the question that requested it.
    pub(super) fn add(self: &Arc<Self>, number: u64, body: Body) {
        let (sender, questions) = mpsc::channel(1);
        self.lock().insert(number, sender);
        let streams = Arc::clone(self);
        tokio::spawn(async move {
            serve(body.into_data_stream(), questions).await;
            streams.end(number);
        });
    }

    /// The bytes since the last call; empty and final for a stream that is not open.
    pub(super) async fn more(&self, number: u64) -> Piece {
        let stream = self.lock().get(&number).cloned();
        let Some(stream) = stream else { return Piece::default() };
        let (tell, told) = oneshot::channel();
        if stream.send(tell).await.is_err() {
            return Piece::default();
        }
        told.await.unwrap_or_default()
    }

    /// Closes a stream.
    pub(super) fn end(&self, number: u64) {
        self.lock().remove(&number);
    }
}

async fn serve(mut frames: BodyDataStream, mut questions: mpsc::Receiver<oneshot::Sender<Piece>>) {
    while let Ok(Some(question)) = timeout(LEASE, questions.recv()).await {
        let (mut piece, mut more) = (Vec::new(), true);
        let mut next = timeout(PATIENCE, frames.next()).await;
        while let Ok(frame) = next {
            match frame {
                Some(Ok(bytes)) => piece.extend_from_slice(&bytes),
                Some(Err(_)) | None => more = false,
            }
            if !more || piece.len() >= FULL {
                break;
            }
            // Adds what is available already.
            next = timeout(Duration::ZERO, frames.next()).await;
        }
        if question.send((piece, more)).is_err() || !more {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use axum::body::Bytes;
    use tokio_stream::wrappers::ReceiverStream;

    use super::*;

    #[tokio::test]
    async fn a_stream_is_read_in_pieces_and_closed_when_nobody_reads_it() {
        let streams = Arc::new(Streams::default());
        let (sender, receiver) = mpsc::channel(8);
        let frames = ReceiverStream::new(receiver).map(Ok::<Bytes, Infallible>);
        streams.add(7, Body::from_stream(frames));
        for text in ["one ", "two"] {
            sender.send(Bytes::from(text)).await.unwrap();
        }
        assert_eq!(streams.more(7).await, (b"one two".to_vec(), true));
        assert_eq!(streams.more(8).await, (Vec::new(), false));
        streams.end(7);
        timeout(LEASE, sender.closed()).await.unwrap();
        assert_eq!(streams.more(7).await, (Vec::new(), false));
    }

    #[tokio::test]
    async fn the_end_of_a_stream_is_told() {
        let streams = Arc::new(Streams::default());
        streams.add(7, Body::from("all"));
        assert_eq!(streams.more(7).await, (b"all".to_vec(), false));
    }
}
