//! What the command line or a configuration says about reading.

use std::path::PathBuf;

/// Options of the preprocessor.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// `-I` directories, in order.
    pub include_dirs: Vec<PathBuf>,
    /// `-D` definitions, `NAME` or `NAME=VALUE`, in order.
    pub defines: Vec<String>,
    /// The program that answers `#pragma requires`; by default `$PKG_CONFIG`, else `pkg-config`.
    pub pkg_config: Option<PathBuf>,
}
