//! Adds a service, a port or a task to a description, and the codels that it asks for to the sources
//! beside it. What was written stays as it is, byte for byte; nothing is written unless the
//! description is sound with the addition.

mod body;
mod declaration;
mod error;
mod files;
mod place;
mod rust;
mod sources;

use std::path::{Path, PathBuf};

use genom_description::source::{Disk, Memory, SourceMap};
use genom_description::{Analysis, Options, parse_files, read_files};

pub use declaration::{Addition, Parameter, ParameterError, Port, Service, Task};
pub use error::AddError;

/// What is to be written.
#[derive(Debug)]
pub struct Added {
    /// Files with their new contents, the description last; none is written yet.
    pub files: Vec<(PathBuf, String)>,
    /// Functions that were added, each with its source.
    pub functions: Vec<(String, PathBuf)>,
    /// What is left to the author.
    pub advice: Vec<String>,
    /// The description with the addition: its warnings are to be told.
    pub analysis: Analysis,
}

/// Works out what `addition` changes in the component that `description` declares.
///
/// # Errors
/// A file cannot be read, the description has mistakes, or would have some with the addition.
pub fn add(description: &Path, options: &Options, addition: &Addition) -> Result<Added, AddError> {
    let inputs = [description.to_owned()];
    let (tokens, parsed) = parse_files(&inputs, options, &Disk);
    let before = parsed.check();
    if before.has_errors() {
        return Err(AddError::Mistakes(Box::new(before)));
    }
    let component = before.specification.components.first();
    let component = component.ok_or_else(|| AddError::NoComponent(description.to_owned()))?;
    let (file, text) = own_text(description, &before.sources)?;
    let body = body::find(&tokens, file, &component.name);
    let body = body.ok_or_else(|| AddError::Elsewhere(description.to_owned()))?;
    let block = addition.block(component)?;
    let text = place::inserted(&text, &body, addition.kind(), &block);

    let mut files = Memory::over_disk();
    files.insert(description, text.clone());
    let after = read_files(&inputs, options, &files);
    if after.has_errors() {
        return Err(AddError::Refused(Box::new(after)));
    }
    let directory = description.parent().unwrap_or(Path::new(""));
    let mut extended = sources::extend(directory, component, &after)?;
    extended.files.push((description.to_owned(), text));
    let files::Extended { files, functions, advice } = extended;
    Ok(Added { files, functions, advice, analysis: after })
}

impl Added {
    /// Writes the files: first beside those that they replace, so that none is changed if one cannot
    /// be written.
    ///
    /// # Errors
    /// A file cannot be written; the error names it.
    pub fn write(&self) -> Result<(), AddError> {
        let beside = |path: &Path| {
            let mut name = path.file_name().unwrap_or_default().to_owned();
            name.push(".new");
            path.with_file_name(name)
        };
        for (path, text) in &self.files {
            let new = beside(path);
            if let Some(parent) = path.parent() {
                std::fs::create_dir_all(parent).map_err(AddError::file(parent))?;
            }
            std::fs::write(&new, text).map_err(AddError::file(&new))?;
            if let Ok(old) = std::fs::metadata(path) {
                let kept = std::fs::set_permissions(&new, old.permissions());
                kept.map_err(AddError::file(&new))?;
            }
        }
        for (path, _) in &self.files {
            std::fs::rename(beside(path), path).map_err(AddError::file(path))?;
        }
        Ok(())
    }
}

/// The index of the description's file, and its text: what is written back must be what was read,
/// but for the addition.
fn own_text(description: &Path, sources: &SourceMap) -> Result<(u32, String), AddError> {
    let text = std::fs::read(description).map_err(AddError::file(description))?;
    let own = sources.files().find(|(_, file)| {
        file.path() == description && file.included_from().is_none() && !file.is_synthetic()
    });
    match (own, String::from_utf8(text)) {
        (Some((index, file)), Ok(text)) if **file.text() == text => Ok((index, text)),
        _ => Err(AddError::Encoding(description.to_owned())),
    }
}
