//! Clients and their rights.

use std::fmt;

use axum::http::StatusCode;
use genom_protocol::{Code, Right};

use crate::error::RpcError;
use crate::slots::Share;

/// The sender of a request.
#[derive(Clone, Debug)]
pub struct Holder {
    /// Its name for messages; never the token itself.
    pub who: String,
    /// Its rights.
    pub rights: Vec<Right>,
    /// The share of slots that it uses.
    pub share: Share,
}

impl Holder {
    /// The client at the Unix socket.
    pub fn own() -> Self {
        let who = "the daemon's user".to_owned();
        Self { who, rights: vec![Right::Admin], share: Share::Own }
    }

    /// Any other client.
    pub fn of(who: String, rights: Vec<Right>) -> Self {
        Self { share: Share::Of(who.clone()), who, rights }
    }

    /// Fails if the holder lacks the right; `what` describes the request in the message.
    ///
    /// # Errors
    /// The right is missing.
    pub fn may(&self, right: Right, what: impl fmt::Display) -> Result<(), RpcError> {
        if self.rights.contains(&right) || self.rights.contains(&Right::Admin) {
            return Ok(());
        }
        let held: Vec<_> = self.rights.iter().map(Right::to_string).collect();
        let held = if held.is_empty() { "no right".to_owned() } else { held.join(", ") };
        let message = format!("{what} needs the right `{right}`; {} has {held}", self.who);
        Err(RpcError::new(StatusCode::FORBIDDEN, Code::RightMissing, message)
            .help("use another token, or add the right in the daemon's token file"))
    }
}
