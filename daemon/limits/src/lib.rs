//! What a process may use: limits of resources, and a sandbox for files and network.
//!
//! A process sets them on itself, before it has a second thread: they then hold for all threads and
//! child processes that it makes, and none of them can undo them. [`apply`] is that call, for a
//! cell; [`close_doors`] takes away what only the start needs.
//!
//! Resources are limited by `setrlimit` ([`resources`]), files by Landlock ([`files`]), network and
//! a few dangerous calls by seccomp ([`calls`]). Nothing here fails silently: what the kernel or
//! missing rights leave undone comes back as sentences for the log.

#![forbid(unsafe_code)]

mod calls;
mod files;
mod grants;
mod memory;
mod resources;
mod rights;

use genom_configuration::CellLimits;

pub use calls::close_doors;
pub use grants::Grants;
pub use memory::lock_memory;

/// Why a process does not run under its limits.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LimitError {
    /// One of the limits cannot be had, and `strict` is set.
    #[error("{}; mend this, or take `strict = true` away", .0.join("; "))]
    Strict(Vec<String>),
}

/// Limits this process. Call it first, while there is one thread.
///
/// Returns what does not hold, as sentences.
///
/// # Errors
/// Something does not hold although `strict` is set.
pub fn apply(limits: &CellLimits, grants: &Grants) -> Result<Vec<String>, LimitError> {
    let mut missing = resources::limit(limits);
    // After the limits, some of which need these rights.
    missing.extend(rights::drop_for(limits));
    if limits.is_sandbox() {
        missing.extend(files::deny_others(limits, grants));
    }
    missing.extend(calls::refuse(limits));
    match limits.strict {
        Some(true) if !missing.is_empty() => Err(LimitError::Strict(missing)),
        _ => Ok(missing),
    }
}
