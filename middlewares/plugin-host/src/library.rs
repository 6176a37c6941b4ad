//! A library that is open and checked.

#![allow(unsafe_code, reason = "what it holds may be used from any thread")]

use std::path::{Path, PathBuf};

use genom_plugin_abi::Host;
use genom_plugin_abi::table::{Plugin, can};

/// A middleware in a library that is open.
pub struct Library {
    pub(crate) path: PathBuf,
    pub(crate) name: String,
    pub(crate) version: String,
    pub(crate) table: Plugin,
    /// What it may call; [`callbacks`] reads the name of this library from it.
    pub(crate) host: Host,
}

impl Library {
    /// Name in configurations and commands.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it says its version is.
    #[must_use]
    pub fn version(&self) -> &str {
        &self.version
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Whether something is gained by opening it in a process of its own.
    #[must_use]
    pub fn wants_gateway(&self) -> bool {
        self.table.capabilities & can::NO_GATEWAY == 0
    }
}

// SAFETY: the table and what the host gives are constant; their pointers are never followed here
// but in calls that any thread may make.
unsafe impl Send for Library {}
// SAFETY: as above.
unsafe impl Sync for Library {}
