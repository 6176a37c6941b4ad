//! Rights, and who holds them.

use std::fmt;

use axum::http::StatusCode;
use serde::{Deserialize, Serialize};

use crate::rpc::error::RpcError;

/// What a token may be good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Right {
    /// Look: components, values, statistics, what changes.
    Read,
    /// Act: services, activities, events, values of in ports, steps of the clock.
    Call,
    /// Connect, disconnect, move between middlewares.
    Wire,
    /// Load, unload, deploy, stop the daemon. Holds the other rights too.
    Admin,
}

impl Right {
    /// The right of that name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        [Self::Read, Self::Call, Self::Wire, Self::Admin]
            .into_iter()
            .find(|right| right.to_string() == name)
    }
}

impl fmt::Display for Right {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Call => "call",
            Self::Wire => "wire",
            Self::Admin => "admin",
        })
    }
}

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
