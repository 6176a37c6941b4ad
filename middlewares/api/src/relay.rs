//! Requests passed from daemon to daemon on a middleware, for supervisors that can reach one daemon
//! and want to talk to another. The bytes are opaque here: daemons seal them.

use std::time::Duration;

use crate::error::DiscoverError;

/// Takes one request and a function that sends the answer, to be called once, from any thread. If
/// it is dropped instead, the other side is told that no answer comes.
pub type OnRequest = dyn Fn(Vec<u8>, Box<dyn FnOnce(Vec<u8>) + Send>) + Send + Sync;

/// A middleware by which daemons reach each other.
pub trait Relay: Send + Sync {
    /// Shows a daemon under a name and takes the requests to it, until the result is dropped.
    ///
    /// # Errors
    /// When a daemon of that name is there already, or the middleware fails.
    fn announce(
        &self,
        name: &str,
        requests: Box<OnRequest>,
    ) -> Result<Box<dyn Send + Sync>, AnnounceError>;

    /// Names of the daemons that are visible now, this one included.
    ///
    /// # Errors
    /// When the middleware cannot tell.
    fn daemons(&self) -> Result<Vec<String>, DiscoverError>;

    /// Identity of this end on the middleware, which others get together with its answers.
    fn own(&self) -> String;

    /// Sends a request to all that take requests to that name, and gathers what they answer, each
    /// with the end of the middleware that it came from, until none is left to answer or
    /// `patience` is over. A daemon that does not show yet is waited for, but not for long.
    ///
    /// Anybody on the network can answer to a name: the answers have to prove who they are from.
    ///
    /// # Errors
    /// No daemon of that name shows, or the middleware fails.
    fn ask_all(
        &self,
        name: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<(String, Vec<u8>)>, AskError>;

    /// Sends a request to the one daemon of that name that is at that end, and waits for the
    /// answer.
    ///
    /// # Errors
    /// It did not answer within `patience`.
    fn ask(
        &self,
        name: &str,
        at: &str,
        request: &[u8],
        patience: Duration,
    ) -> Result<Vec<u8>, AskError>;
}

/// A daemon cannot be shown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AnnounceError {
    /// Another one has its name.
    #[error(
        "another daemon named `{name}` is reachable on {backend}: start one of the two with a name \
         of its own, `--daemon NAME`"
    )]
    Taken {
        /// As the daemon is called.
        name: String,
        /// The middleware that was used.
        backend: String,
    },
    /// The middleware itself failed.
    #[error("daemon `{name}` is not reachable on {backend}: {why}")]
    Failed {
        /// As the daemon is called.
        name: String,
        /// The middleware that was used.
        backend: String,
        /// The middleware's own words.
        why: String,
    },
}

/// A request to another daemon came to nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AskError {
    /// No daemon of that name shows.
    #[error("no daemon `{name}` shows on {backend}")]
    Unknown {
        /// As the daemon is called.
        name: String,
        /// The middleware that was used.
        backend: String,
    },
    /// It did not answer.
    #[error("daemon {name} on {backend} does not answer: {why}")]
    Silent {
        /// As the daemon is called.
        name: String,
        /// The middleware that was used.
        backend: String,
        /// What is known of the reason.
        why: String,
    },
}
