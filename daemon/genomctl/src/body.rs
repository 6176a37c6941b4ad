//! The body of a reply, over HTTP or through a relay.

use http_body_util::BodyExt as _;
use hyper::body::{Bytes, Incoming};
use tokio::sync::mpsc;

use crate::failure::Failure;
use crate::patience::Watch;

/// A body that is read piece by piece.
pub(crate) enum Body {
    /// From the daemon that genomctl is connected to.
    Near(Incoming, Watch),
    /// From another daemon, relayed by that one.
    Far(mpsc::Receiver<Result<Bytes, Failure>>),
    /// The complete body.
    Whole(Option<Bytes>),
}

impl Body {
    /// The next piece; `None` at the end, or when the daemon closed the connection. Fails when the
    /// daemon stops answering any requests. Cancel safe.
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

    /// The whole body; `None` when the daemon closed the connection before its end.
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
