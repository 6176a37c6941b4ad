//! The body of a reply, wherever it comes from.

use http_body_util::BodyExt as _;
use hyper::body::{Bytes, Incoming};
use tokio::sync::mpsc;

/// A body that is read as it comes.
pub(crate) enum Body {
    /// From the daemon that was connected to.
    Near(Incoming),
    /// From another one, behind it: piece by piece.
    Far(mpsc::Receiver<Bytes>),
    /// All there is.
    Whole(Option<Bytes>),
}

impl Body {
    /// What comes next; `None` at the end, and when the daemon went away. May be dropped and
    /// called again.
    pub(crate) async fn next(&mut self) -> Option<Bytes> {
        loop {
            match self {
                Self::Near(body) => match body.frame().await?.ok()?.into_data() {
                    Ok(bytes) => return Some(bytes),
                    Err(_) => continue,
                },
                Self::Far(pieces) => return pieces.recv().await,
                Self::Whole(bytes) => return bytes.take(),
            }
        }
    }

    /// All of it; `None` when the daemon went away.
    pub(crate) async fn whole(self) -> Option<Bytes> {
        match self {
            Self::Near(body) => Some(body.collect().await.ok()?.to_bytes()),
            Self::Far(mut pieces) => {
                let mut all = Vec::new();
                while let Some(piece) = pieces.recv().await {
                    all.extend_from_slice(&piece);
                }
                Some(all.into())
            }
            Self::Whole(bytes) => Some(bytes.unwrap_or_default()),
        }
    }
}
