//! Requests from one daemon to another through a middleware, for clients that can reach only one of
//! the two. The bytes are opaque to the middleware: the daemons encrypt and authenticate them.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::error::DiscoverError;

/// Handles one request. The second argument sends the reply; it is called once, from any thread.
/// Dropping it instead tells the other side that there will be no reply.
pub type OnRequest = dyn Fn(Vec<u8>, Box<dyn FnOnce(Vec<u8>) + Send>) + Send + Sync;

/// A middleware through which daemons reach each other.
pub trait Relay: Send + Sync {
    /// Makes a daemon reachable under a name, and passes requests for that name to `on_request`,
    /// until the result is dropped.
    ///
    /// # Errors
    /// Another daemon has that name, or the middleware fails.
    fn announce(
        &self,
        name: &str,
        requests: Box<OnRequest>,
    ) -> Result<Box<dyn Send + Sync>, AnnounceError>;

    /// Names of the daemons that are visible now, including this one.
    ///
    /// # Errors
    /// When the middleware cannot list them.
    fn daemons(&self) -> Result<Vec<String>, DiscoverError>;

    /// Identity of this end on the middleware. Others receive it along with its replies.
    fn own(&self) -> String;

    /// Sends a request to every end that serves that name and collects the replies, each with the
    /// identity of the end that sent it. Returns when all have replied or after `patience`. If no
    /// such daemon is visible yet, waits a short time for it.
    ///
    /// Anybody on the network can reply under any name, so callers must authenticate the replies.
    ///
    /// # Errors
    /// No daemon of that name is visible, or the middleware fails.
    fn ask_all(
        &self,
        name: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<(String, Vec<u8>)>, AskError>;

    /// Sends a request to the daemon of that name at that end, and waits for the reply.
    ///
    /// # Errors
    /// There was no reply within `patience`.
    fn ask(
        &self,
        name: &str,
        at: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<u8>, AskError>;
}

/// A daemon cannot be made reachable.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[non_exhaustive]
pub enum AnnounceError {
    /// Another daemon has this name.
    #[error(
        "another daemon named `{name}` is reachable on {backend}: start one of the two with a name \
         of its own, `--daemon NAME`"
    )]
    Taken {
        /// Name of the daemon.
        name: String,
        /// The middleware that was used.
        backend: String,
    },
    /// The middleware itself failed.
    #[error("daemon `{name}` is not reachable on {backend}: {why}")]
    Failed {
        /// Name of the daemon.
        name: String,
        /// The middleware that was used.
        backend: String,
        /// The middleware's own message.
        why: String,
    },
}

/// A request to another daemon failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
#[non_exhaustive]
pub enum AskError {
    /// No daemon of that name is visible.
    #[error("no daemon `{name}` shows on {backend}")]
    Unknown {
        /// Name of the daemon.
        name: String,
        /// The middleware that was used.
        backend: String,
    },
    /// It did not reply.
    #[error("daemon {name} on {backend} does not answer: {why}")]
    Silent {
        /// Name of the daemon.
        name: String,
        /// The middleware that was used.
        backend: String,
        /// The reason, as far as it is known.
        why: String,
    },
}
