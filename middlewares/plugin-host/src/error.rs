//! Why a library is no middleware that can be used.

use std::path::PathBuf;

use genom_plugin_abi::{MAJOR, MINOR, SYMBOL};

/// A library cannot be used as a middleware.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum LibraryError {
    /// There is no such file, or it may not be read.
    #[error("cannot read {path}: {why}")]
    Missing { path: PathBuf, why: String },
    /// The dynamic linker refused it.
    #[error("cannot open {path}: {why}")]
    Linker { path: PathBuf, why: String },
    /// It has no table.
    #[error(
        "{path} is no middleware: it does not export `{SYMBOL}`, which genom3/middleware.h declares"
    )]
    NoPlugin { path: PathBuf },
    /// Another major version.
    #[error(
        "{path} was built for version {major}.{minor} of genom3/middleware.h, this genomd has \
         {MAJOR}.{MINOR}: build it with the header that `genomctl sdk` installs"
    )]
    Version { path: PathBuf, major: u16, minor: u16 },
    /// The table is too short.
    #[error(
        "the table of {path} has {size} bytes, and version {MAJOR}.0 has {least}: `size` has to be \
         sizeof(genom_mw_plugin)"
    )]
    Short { path: PathBuf, size: usize, least: usize },
    /// A function is missing that every middleware has, or that its capabilities need.
    #[error("the table of {path} has no `{function}`, which {why}")]
    Lacks { path: PathBuf, function: &'static str, why: &'static str },
    /// Its name is none.
    #[error(
        "the table of {path} names the middleware `{name}`: names have 1 to 32 of a to z, 0 to 9 \
         and _, and begin with a letter"
    )]
    Name { path: PathBuf, name: String },
    /// It could not open its middleware.
    #[error("{why}")]
    Refused { why: String },
}
