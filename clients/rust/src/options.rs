//! How a daemon is to be started.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// How a daemon is to be started. Without a configuration file nothing of it reaches other daemons on
/// this machine.
#[derive(Clone, Debug, Default)]
pub struct Options {
    pub(crate) program: Option<PathBuf>,
    pub(crate) config: Option<PathBuf>,
    pub(crate) arguments: Vec<OsString>,
}

impl Options {
    /// A daemon without components: `$GENOMD`, or `genomd` on `PATH`.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// This genomd.
    #[must_use]
    pub fn program(mut self, program: impl AsRef<Path>) -> Self {
        self.program = Some(program.as_ref().to_owned());
        self
    }

    /// With a configuration file of genomd, which may hold a deployment.
    #[must_use]
    pub fn config(mut self, file: impl AsRef<Path>) -> Self {
        self.config = Some(file.as_ref().to_owned());
        self
    }

    /// With one more argument of genomd: an option, or a component to load before it is ready.
    #[must_use]
    pub fn argument(mut self, argument: impl AsRef<OsStr>) -> Self {
        self.arguments.push(argument.as_ref().to_owned());
        self
    }
}
