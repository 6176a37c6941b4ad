//! The default socket of a user's daemon.

use std::path::PathBuf;

/// `$XDG_RUNTIME_DIR/genomd.sock`, else `/tmp/genomd-UID/genomd.sock`.
#[must_use]
pub fn default_path() -> PathBuf {
    match std::env::var_os("XDG_RUNTIME_DIR").filter(|directory| !directory.is_empty()) {
        Some(directory) => PathBuf::from(directory).join("genomd.sock"),
        None => {
            let user = rustix::process::getuid().as_raw();
            PathBuf::from(format!("/tmp/genomd-{user}/genomd.sock"))
        }
    }
}
