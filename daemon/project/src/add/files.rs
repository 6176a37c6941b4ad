//! The sources of a project, as they are and as they will be.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::AddError;
use crate::skeleton::Source;

/// What is added to the sources.
#[derive(Debug, Default)]
pub(super) struct Extended {
    /// Files with their new contents.
    pub(super) files: Vec<(PathBuf, String)>,
    /// Functions that were added, each with its source.
    pub(super) functions: Vec<(String, PathBuf)>,
    /// What is left to the author.
    pub(super) advice: Vec<String>,
}

/// Files of a folder with one of these endings, by their path below `directory`.
pub(super) fn read(
    directory: &Path,
    folder: &Path,
    endings: &[&str],
) -> Result<Vec<Source>, AddError> {
    let mut list = Vec::new();
    let place = directory.join(folder);
    let shown = if place.as_os_str().is_empty() { Path::new(".") } else { &place };
    for entry in fs::read_dir(shown).map_err(AddError::file(shown))? {
        let path = entry.map_err(AddError::file(shown))?.path();
        let ending = path.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
        if endings.contains(&ending) && path.is_file() {
            let text = fs::read(&path).map_err(AddError::file(&path))?;
            let text = String::from_utf8(text).map_err(|_| AddError::Encoding(path.clone()))?;
            list.push(Source { path: folder.join(path.file_name().unwrap_or_default()), text });
        }
    }
    list.sort_by(|one, other| one.path.cmp(&other.path));
    Ok(list)
}
