//! Who holds rights.

use std::fmt;

use axum::http::StatusCode;
use genom_configuration::Right;
use genom_protocol::Code;

use crate::rpc::error::RpcError;
use crate::slots::Share;

/// Whoever sent a request.
#[derive(Clone, Debug)]
pub(crate) struct Holder {
    /// Who it is, for messages: never the token itself.
    pub(crate) who: String,
    pub(crate) rights: Vec<Right>,
    /// Whose slots it takes for what it holds open.
    pub(crate) share: Share,
}

impl Holder {
    /// Whoever came by the Unix socket.
    pub(crate) fn own() -> Self {
        let who = "the daemon's user".to_owned();
        Self { who, rights: vec![Right::Admin], share: Share::Own }
    }

    /// Somebody else.
    pub(crate) fn of(who: String, rights: Vec<Right>) -> Self {
        Self { share: Share::Of(who.clone()), who, rights }
    }

    /// Refuses what it has no right to.
    pub(crate) fn may(&self, right: Right, what: impl fmt::Display) -> Result<(), RpcError> {
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
