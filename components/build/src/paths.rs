//! Where things are, and files that keep their date.

use std::path::{Path, PathBuf};

use crate::error::BuildError;

/// Where the repository is, and where what is built goes.
#[derive(Clone, Debug)]
pub struct Paths {
    /// Root of the workspace.
    pub root: PathBuf,
    /// Cargo's target directory; components go to `components/` below it.
    pub target: PathBuf,
}

impl Paths {
    /// This repository, with the target directory that cargo uses now.
    ///
    /// # Errors
    /// Cargo cannot be run, or refuses the workspace.
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

/// Copies a small file; one that is the same already keeps its date.
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
