//! Where users keep the states of programs.

use std::path::PathBuf;

/// `$XDG_STATE_HOME`, else `~/.local/state`; `None` without any of them.
pub(crate) fn state() -> Option<PathBuf> {
    let variable = |name| std::env::var_os(name).map(PathBuf::from);
    let absolute = |path: &PathBuf| path.is_absolute();
    let home = || variable("HOME").filter(absolute).map(|home| home.join(".local/state"));
    variable("XDG_STATE_HOME").filter(absolute).or_else(home)
}
