//! Paths of the workspace, and copies that keep dates.

use std::path::{Path, PathBuf};

use crate::error::BuildError;

/// Paths of the repository and of what is built.
#[derive(Clone, Debug)]
pub struct Paths {
    /// Root of the workspace.
    pub root: PathBuf,
    /// Cargo's target directory; components are built in `components/` below it.
    pub target: PathBuf,
}

impl Paths {
    /// The paths of this workspace, with the target directory that cargo uses.
    ///
    /// # Errors
    /// Cargo cannot be run, or it does not accept the workspace.
    pub fn of_workspace() -> Result<Self, BuildError> {
        let metadata = cargo_metadata::MetadataCommand::new()
            .manifest_path(Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"))
            .no_deps()
            .exec()?;
        Ok(Self {
            root: metadata.workspace_root.into_std_path_buf(),
            target: metadata.target_directory.into_std_path_buf(),
        })
    }
}

/// Copies a small file, unless the copy has the same content already: it then keeps its date.
pub(crate) fn copy_if_changed(from: &Path, to: &Path) -> Result<(), BuildError> {
    let contents = std::fs::read(from).map_err(BuildError::file(from))?;
    if std::fs::read(to).is_ok_and(|old| old == contents) {
        return Ok(());
    }
    let parent = to.parent().unwrap_or(Path::new("."));
    let fresh = parent.join(".fresh");
    std::fs::write(&fresh, contents).map_err(BuildError::file(&fresh))?;
    std::fs::rename(&fresh, to).map_err(BuildError::file(to))
}
