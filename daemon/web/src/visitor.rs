//! Who opens the console, and with which rights.

use genom_doors::{Holder, Mark, Share, Tokens};
use genom_protocol::Right;
use serde::{Deserialize, Serialize};

/// Whoever asked for a link or has a token, as long as a session of theirs lasts.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Visitor {
    /// Name for messages and the log.
    pub(crate) who: String,
    /// Rights of the session.
    pub(crate) rights: Vec<Right>,
    /// What they rest on.
    pub(crate) ground: Ground,
}

/// What the rights of a session rest on.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Ground {
    /// The Unix socket.
    Owner,
    /// A token of the token file, as long as it is there.
    Token(Mark),
    /// A client certificate, which TLS has checked.
    Certificate,
}

impl Visitor {
    /// The visitor that this client is or makes a link for.
    pub(crate) fn of(holder: &Holder, rights: Option<Vec<Right>>, tokens: &Tokens) -> Self {
        let ground = match (&holder.share, tokens.mark(holder)) {
            (Share::Own, _) => Ground::Owner,
            (_, Some(mark)) => Ground::Token(mark),
            (_, None) => Ground::Certificate,
        };
        let rights = rights.unwrap_or_else(|| holder.rights.clone());
        Self { who: holder.who.clone(), rights, ground }
    }

    /// The rights that it has now; `None` if its token is gone.
    pub(crate) fn rights_now(&self, tokens: &Tokens) -> Option<Vec<Right>> {
        let Ground::Token(mark) = &self.ground else { return Some(self.rights.clone()) };
        let now = tokens.rights(mark)?;
        let has = |right: &&Right| now.contains(right) || now.contains(&Right::Admin);
        Some(self.rights.iter().filter(has).copied().collect())
    }
}
