//! How a backend is opened: by its section of a configuration.

use std::fmt::Display;
use std::sync::Arc;

use serde::de::DeserializeOwned;

use crate::Middleware;

/// A middleware that a daemon can be built with.
///
/// The daemon names each of its backends in one place and asks here for all the rest: what its
/// section of the configuration may say, whether what it says makes sense, and the open middleware.
pub trait Backend {
    /// As configurations and commands call it; also [`Middleware::name`].
    const NAME: &'static str;

    /// The library behind it, for people who look: `zenoh 1.10`.
    const VERSION: &'static str;

    /// `[backends.NAME]`. Every key has a default, and unknown ones are errors
    /// (`#[serde(default, deny_unknown_fields)]`), so that a typo is told with its line.
    type Options: DeserializeOwned;

    /// Why it does not open; it names the key where an option is to blame.
    type Error: Display;

    /// Refuses options that make no sense, and opens nothing: also those of backends that are not
    /// in use are looked at when the daemon starts.
    ///
    /// # Errors
    /// An option is out of range, or options contradict each other.
    fn check(options: &Self::Options) -> Result<(), Self::Error> {
        let _ = options;
        Ok(())
    }

    /// Opens it.
    ///
    /// # Errors
    /// As [`check`](Backend::check), or it cannot be had on this machine.
    fn open(options: Self::Options) -> Result<Arc<dyn Middleware>, Self::Error>;
}
