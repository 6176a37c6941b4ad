//! How a backend is opened from its section of the configuration.

use std::fmt::Display;
use std::path::PathBuf;
use std::sync::Arc;

use serde::de::DeserializeOwned;

use crate::Middleware;

/// A middleware that a daemon can be built with.
///
/// The registry lists each backend once. Everything else comes from here: which options its section
/// of the configuration accepts, whether their values are valid, and the opened middleware.
pub trait Backend {
    /// Name in configurations and commands; the same as [`Middleware::name`].
    const NAME: &'static str;

    /// Name and version of the library underneath, for people to read: `zenoh 1.10`.
    const VERSION: &'static str;

    /// Whether it can be opened in a process of its own: its subscriptions tell of samples that
    /// arrive, and nothing is gained from sharing a process with it.
    const GATEWAY: bool = false;

    /// Type of the section `[backends.NAME]`. Every key has a default, and unknown keys are errors
    /// (`#[serde(default, deny_unknown_fields)]`), so that a typing error is reported with its
    /// line.
    type Options: DeserializeOwned;

    /// Why the backend cannot be opened. The message names the key if an option is the cause.
    type Error: Display;

    /// Checks the options without opening anything. The daemon calls this at start for every
    /// backend, including those it does not use.
    ///
    /// # Errors
    /// An option is out of range, or options contradict each other.
    fn check(options: &Self::Options) -> Result<(), Self::Error> {
        let _ = options;
        Ok(())
    }

    /// Directories in which it makes files on this machine: a process that may not write elsewhere
    /// needs them.
    fn places(options: &Self::Options) -> Vec<PathBuf> {
        let _ = options;
        Vec::new()
    }

    /// Opens the middleware.
    ///
    /// # Errors
    /// The same as [`check`](Backend::check), or the middleware is not available on this machine.
    fn open(options: Self::Options) -> Result<Arc<dyn Middleware>, Self::Error>;
}
