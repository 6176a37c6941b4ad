//! Why the daemon does not run, or ended.

use std::io::Write as _;

use genom_host::StandardError;

/// Why the daemon failed, with its exit status.
#[derive(Debug)]
pub(crate) struct Refusal {
    message: String,
    status: u8,
}

impl Refusal {
    /// Status 1: a component was refused.
    pub(crate) fn component(error: impl std::fmt::Display) -> Self {
        Self { message: error.to_string(), status: 1 }
    }

    /// Status 2: wrong usage or configuration.
    pub(crate) fn usage(error: impl std::fmt::Display) -> Self {
        Self { message: error.to_string(), status: 2 }
    }

    /// Status 3: the daemon's own socket or middleware could not be opened.
    pub(crate) fn own(error: impl std::fmt::Display) -> Self {
        Self { message: error.to_string(), status: 3 }
    }

    /// Status 4: it stopped, but a component was left behind.
    pub(crate) fn left_behind(message: String) -> Self {
        Self { message, status: 4 }
    }

    /// What it says.
    pub(crate) fn message(&self) -> &str {
        &self.message
    }

    /// Prints the message on standard error; returns the exit status.
    pub(crate) fn report(&self) -> u8 {
        // Formatted diagnostics of a description begin with `error` themselves.
        let prefix = if self.message.starts_with("error") { "" } else { "error: " };
        let text = format!("{prefix}{}\n", self.message.trim_end());
        let _ = StandardError::get().write_all(text.as_bytes());
        self.status
    }
}
