//! Options of reading, from the command line or a configuration.

use std::path::PathBuf;

/// Options of the preprocessor.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `-I` directories, in order.
    pub include_dirs: Vec<PathBuf>,
    /// `-D` definitions, `NAME` or `NAME=VALUE`, in order.
    pub defines: Vec<String>,
    /// The program to run for `#pragma requires`; by default `$PKG_CONFIG`, else `pkg-config`.
    pub pkg_config: Option<PathBuf>,
}
