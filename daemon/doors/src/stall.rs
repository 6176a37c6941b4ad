//! A connection that fails if its peer reads nothing for [`PATIENCE`], so that a peer cannot keep
//! it open by not reading.

use std::io::{self, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::time::{Instant, Sleep, sleep};

/// How long a peer may read nothing.
const PATIENCE: Duration = Duration::from_secs(10);

/// Fails a write of which nothing is taken for [`PATIENCE`].
#[derive(Debug)]
pub(crate) struct Unstalled<S> {
    inner: S,
    patience: Duration,
    alarm: Pin<Box<Sleep>>,
    /// Whether the last write waits for the peer; the timer runs only then.
    waits: bool,
}

impl<S> Unstalled<S> {
    pub(crate) fn new(inner: S) -> Self {
        Self::with(inner, PATIENCE)
    }

    fn with(inner: S, patience: Duration) -> Self {
        Self { inner, patience, alarm: Box::pin(sleep(patience)), waits: false }
    }
}

impl<S: AsyncWrite + Unpin> Unstalled<S> {
    fn watch<T>(
        &mut self,
        context: &mut Context<'_>,
        work: impl FnOnce(Pin<&mut S>, &mut Context<'_>) -> Poll<io::Result<T>>,
    ) -> Poll<io::Result<T>> {
        let outcome = work(Pin::new(&mut self.inner), context);
        if outcome.is_ready() {
            self.waits = false;
            return outcome;
        }
        if !self.waits {
            self.waits = true;
            self.alarm.as_mut().reset(Instant::now() + self.patience);
        }
        ready!(self.alarm.as_mut().poll(context));
        let message = "the peer does not read";
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, message)))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Unstalled<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.inner).poll_read(context, buffer)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Unstalled<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        self.watch(context, |inner, context| inner.poll_write(context, bytes))
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.watch(context, |inner, context| inner.poll_flush(context))
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        self.watch(context, |inner, context| inner.poll_shutdown(context))
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        self.watch(context, |inner, context| inner.poll_write_vectored(context, slices))
    }

    fn is_write_vectored(&self) -> bool {
        self.inner.is_write_vectored()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, duplex};

    #[tokio::test]
    async fn a_peer_that_does_not_read_is_given_up() {
        let (ours, _theirs) = duplex(4);
        let mut ours = Unstalled::with(ours, Duration::from_millis(1));
        let error = ours.write_all(b"more than four").await.unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::TimedOut);
    }

    #[tokio::test]
    async fn a_peer_that_reads_slowly_gets_everything() {
        let (ours, mut theirs) = duplex(1);
        let mut ours = Unstalled::with(ours, Duration::from_secs(3600));
        let reading = tokio::spawn(async move {
            let mut all = vec![0; 8];
            theirs.read_exact(&mut all).await.map(|_| all)
        });
        ours.write_all(b"12345678").await.unwrap();
        assert_eq!(reading.await.unwrap().unwrap(), b"12345678");
    }
}
