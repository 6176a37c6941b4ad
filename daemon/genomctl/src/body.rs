//! The body of a reply, wherever it comes from.

use http_body_util::BodyExt as _;
use hyper::body::{Bytes, Incoming};
use tokio::sync::mpsc;

use crate::failure::Failure;
use crate::patience::Watch;

/// A body that is read as it comes.
pub(crate) enum Body {
    /// From the daemon that was connected to.
    Near(Incoming, Watch),
    /// From another one, behind it: piece by piece.
    Far(mpsc::Receiver<Result<Bytes, Failure>>),
    /// All there is.
    Whole(Option<Bytes>),
}

impl Body {
    /// The next piece; `None` at the end, and when the daemon went away; a failure when it answers
    /// nobody any more. Nothing is lost when the future is dropped before it is ready.
    pub(crate) async fn next(&mut self) -> Result<Option<Bytes>, Failure> {
        loop {
            match self {
                Self::Near(body, watch) => match watch.over(body.frame()).await? {
                    None | Some(Err(_)) => return Ok(None),
                    Some(Ok(frame)) => match frame.into_data() {
                        Ok(bytes) => return Ok(Some(bytes)),
                        Err(_) => continue,
                    },
                },
                Self::Far(pieces) => return pieces.recv().await.transpose(),
                Self::Whole(bytes) => return Ok(bytes.take()),
            }
        }
    }

    /// All of it; `None` when the daemon went away.
    pub(crate) async fn whole(self) -> Result<Option<Bytes>, Failure> {
        match self {
            Self::Near(body, watch) => {
                Ok(watch.over(body.collect()).await?.ok().map(|all| all.to_bytes()))
            }
            Self::Far(mut pieces) => {
                let mut all = Vec::new();
                while let Some(piece) = pieces.recv().await {
                    all.extend_from_slice(&piece?);
                }
                Ok(Some(all.into()))
            }
            Self::Whole(bytes) => Ok(Some(bytes.unwrap_or_default())),
        }
    }
}
