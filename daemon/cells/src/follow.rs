//! What a cell tells as it happens: its changes and its log, told on by the daemon.

use http_body_util::BodyExt as _;
use hyper::body::Incoming;
use serde_json::Value;

use genom_protocol::sse::{Event, Parser};

use crate::client::{AskError, Client};

/// The events of one stream of a cell, from its start on.
pub(crate) struct Events {
    body: Incoming,
    parser: Parser,
}

impl Events {
    /// Opens the stream at a path; `Some(0)` hears what was told before, too.
    pub(crate) async fn open(
        client: &Client,
        path: &str,
        after: Option<u64>,
    ) -> Result<Self, AskError> {
        let response = client.open(path, after).await?;
        if !response.status().is_success() {
            return Err(AskError::Misread(format!("status {}", response.status())));
        }
        Ok(Self { body: response.into_body(), parser: Parser::default() })
    }

    /// The next event with its number; `None` when the stream is over.
    pub(crate) async fn next(&mut self) -> Option<(Option<u64>, Value)> {
        loop {
            if let Some(Event { id, data, .. }) = self.parser.next() {
                match serde_json::from_str(&data) {
                    Ok(value) => return Some((id, value)),
                    Err(_) => continue,
                }
            }
            let frame = self.body.frame().await?.ok()?;
            if let Some(bytes) = frame.data_ref() {
                self.parser.feed(bytes);
            }
        }
    }
}
