//! Builds the components of this repository, each as `NAME.so`, or `NAME.py`, with `NAME.gen` beside it.
//!
//! It is used by tests and by `cargo demo`. It is not a build system for other components, whose
//! codels may be compiled in any way.

#![forbid(unsafe_code)]

mod cargo;
mod compile;
pub mod debian;
mod error;
pub mod hiroz;
pub mod node;
mod paths;
pub mod peer;
pub mod python;
mod recipe;
pub mod ros2;
pub mod yarp;

use std::fs::File;
use std::path::{Path, PathBuf};

pub use cargo::{Purpose, build_programs};
pub use error::BuildError;
pub use paths::Paths;
use paths::copy_if_changed;
use recipe::{Language, Recipe};

/// A component that was built.
#[derive(Clone, Debug)]
pub struct Artifact {
    /// Name of its directory under `target/components/`. The figures of the two papers are
    /// `demo-2010` and `demo-2011`, although the name of both components is `demo`.
    pub name: String,
    /// Path of the library, or of the script of codels in Python.
    pub library: PathBuf,
    /// Path of the `.gen` file beside it.
    pub description: PathBuf,
}

/// Builds every component of the repository that is not up to date.
///
/// If several processes do so at once, one builds and the others wait.
///
/// # Errors
/// A compiler is missing or fails, or a file cannot be written.
pub fn build_all(paths: &Paths, purpose: Purpose) -> Result<Vec<Artifact>, BuildError> {
    let _lock = lock(paths)?;
    recipe::all(&paths.root)?.iter().map(|recipe| make(paths, recipe, purpose)).collect()
}

/// Builds one component, unless it is up to date.
///
/// # Errors
/// As for [`build_all`]; or no component has this name.
pub fn build(paths: &Paths, name: &str, purpose: Purpose) -> Result<Artifact, BuildError> {
    let _lock = lock(paths)?;
    let recipes = recipe::all(&paths.root)?;
    match recipes.iter().find(|recipe| recipe.name == name) {
        Some(recipe) => make(paths, recipe, purpose),
        None => Err(BuildError::Unknown {
            name: name.to_owned(),
            known: recipes.iter().map(|recipe| recipe.name.as_str()).collect::<Vec<_>>().join(", "),
        }),
    }
}

/// Locks out other processes until the result is dropped.
fn lock(paths: &Paths) -> Result<File, BuildError> {
    let directory = paths.target.join("components");
    std::fs::create_dir_all(&directory).map_err(BuildError::file(&directory))?;
    let path = directory.join(".lock");
    let lock = File::create(&path).map_err(BuildError::file(&path))?;
    lock.lock().map_err(BuildError::file(&path))?;
    Ok(lock)
}

fn make(paths: &Paths, recipe: &Recipe, purpose: Purpose) -> Result<Artifact, BuildError> {
    let directory = paths.target.join("components").join(&recipe.name);
    std::fs::create_dir_all(&directory).map_err(BuildError::file(&directory))?;
    let kind = match recipe.language {
        Language::Script(extension) => extension,
        Language::C | Language::Rust => "so",
    };
    let artifact = Artifact {
        name: recipe.name.clone(),
        library: directory.join(format!("{}.{kind}", recipe.stem)),
        description: directory.join(format!("{}.gen", recipe.stem)),
    };
    match recipe.language {
        Language::C => compile::library(paths, recipe, &artifact.library)?,
        Language::Rust => cargo::library(paths, recipe, &artifact.library, purpose)?,
        Language::Script(extension) => {
            let script = recipe.directory.join(format!("{}.{extension}", recipe.stem));
            copy_if_changed(&script, &artifact.library)?;
        }
    }
    for source in &recipe.descriptions {
        let name = match source.extension() {
            Some(extension) if extension == "gen" => artifact.description.clone(),
            _ => directory.join(source.file_name().unwrap_or_default()),
        };
        copy_if_changed(source, &name)?;
    }
    for source in &recipe.shared {
        let folder = source.parent().and_then(Path::file_name).unwrap_or_default();
        let folder = paths.target.join("components").join(folder);
        std::fs::create_dir_all(&folder).map_err(BuildError::file(&folder))?;
        copy_if_changed(source, &folder.join(source.file_name().unwrap_or_default()))?;
    }
    Ok(artifact)
}
