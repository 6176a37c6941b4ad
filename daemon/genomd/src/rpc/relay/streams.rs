//! Replies without an end that other daemons read piece by piece.
//!
//! A relay knows questions and answers only: the reader asks for what has come since. It reads as
//! fast as it likes, and when it asks no more, whatever became of it, the stream is closed.

use std::collections::HashMap;
use std::io::Read as _;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use axum::body::{Body, BodyDataStream};
use tokio::sync::{mpsc, oneshot};
use tokio::time::timeout;
use tokio_stream::StreamExt as _;

/// How long a question waits for something to answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// A stream that is not asked for so long is closed; readers may pause for less than that.
const LEASE: Duration = Duration::from_secs(20);

/// An answer is sent when it has that many bytes.
const FULL: usize = 256 << 10;

/// A piece, and whether there may be more.
type Piece = (Vec<u8>, bool);

/// The open streams, each by a name that nobody guesses.
#[derive(Debug, Default)]
pub(super) struct Streams {
    open: Mutex<HashMap<String, mpsc::Sender<oneshot::Sender<Piece>>>>,
}

impl Streams {
    fn lock(&self) -> MutexGuard<'_, HashMap<String, mpsc::Sender<oneshot::Sender<Piece>>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps a body to be read; its name.
    pub(super) fn add(self: &Arc<Self>, body: Body) -> std::io::Result<String> {
        let mut random = [0; 16];
        std::fs::File::open("/dev/urandom")?.read_exact(&mut random)?;
        let name = format!("{:032x}", u128::from_ne_bytes(random));
        let (sender, questions) = mpsc::channel(1);
        self.lock().insert(name.clone(), sender);
        let (streams, own) = (Arc::clone(self), name.clone());
        tokio::spawn(async move {
            serve(body.into_data_stream(), questions).await;
            streams.end(&own);
        });
        Ok(name)
    }

    /// What came since the last time; none, and no more, of a stream that is not open.
    pub(super) async fn more(&self, name: &str) -> Piece {
        let stream = self.lock().get(name).cloned();
        let Some(stream) = stream else { return Piece::default() };
        let (tell, told) = oneshot::channel();
        if stream.send(tell).await.is_err() {
            return Piece::default();
        }
        told.await.unwrap_or_default()
    }

    /// Closes a stream.
    pub(super) fn end(&self, name: &str) {
        self.lock().remove(name);
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
            // Whatever else is there already.
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
        let name = streams.add(Body::from_stream(frames)).unwrap();
        for text in ["one ", "two"] {
            sender.send(Bytes::from(text)).await.unwrap();
        }
        assert_eq!(streams.more(&name).await, (b"one two".to_vec(), true));
        assert_eq!(streams.more("another").await, (Vec::new(), false));
        streams.end(&name);
        timeout(LEASE, sender.closed()).await.unwrap();
        assert_eq!(streams.more(&name).await, (Vec::new(), false));
    }

    #[tokio::test]
    async fn the_end_of_a_stream_is_told() {
        let streams = Arc::new(Streams::default());
        let name = streams.add(Body::from("all")).unwrap();
        assert_eq!(streams.more(&name).await, (b"all".to_vec(), false));
    }
}
