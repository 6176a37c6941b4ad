//! Who holds rights.

use std::fmt;

use axum::http::StatusCode;

use crate::config::Right;
use crate::rpc::error::RpcError;

/// Whoever sent a request.
#[derive(Clone, Debug)]
pub(crate) struct Holder {
    /// Who it is, for messages: never the token itself.
    pub(crate) who: String,
    pub(crate) rights: Vec<Right>,
}

impl Holder {
    /// Refuses what it has no right to.
    pub(crate) fn may(&self, right: Right, what: impl fmt::Display) -> Result<(), RpcError> {
        if self.rights.contains(&right) || self.rights.contains(&Right::Admin) {
            return Ok(());
        }
        let held: Vec<_> = self.rights.iter().map(Right::to_string).collect();
        let held = if held.is_empty() { "no right".to_owned() } else { held.join(", ") };
        let message = format!("{what} needs the right `{right}`; {} has {held}", self.who);
        Err(RpcError::new(StatusCode::FORBIDDEN, "right_missing", message)
            .help("use another token, or add the right in the daemon's token file"))
    }
}
