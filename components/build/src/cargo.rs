//! Libraries of codels in Rust, and programs of the workspace, through cargo.

use std::path::{Path, PathBuf};
use std::process::Command;

use cargo_metadata::{Artifact, CrateType, Message};

use crate::recipe::Recipe;
use crate::{BuildError, Paths};

/// Makes `library` of the package of the recipe's name.
pub(crate) fn library(paths: &Paths, recipe: &Recipe, library: &Path) -> Result<(), BuildError> {
    let artifacts = cargo_build(paths, &["--package", &recipe.name])?;
    let built = artifacts
        .iter()
        .filter(|artifact| artifact.target.crate_types.contains(&CrateType::CDyLib))
        .filter(|artifact| artifact.target.name == recipe.name.replace('-', "_"))
        .flat_map(|artifact| &artifact.filenames)
        .find(|file| file.extension() == Some("so"));
    let Some(built) = built else {
        return Err(BuildError::NoArtifact { package: recipe.name.clone(), what: "cdylib" });
    };
    crate::copy_if_changed(built.as_std_path(), library)
}

/// Builds a program of the workspace and tells where it is.
///
/// # Errors
/// Cargo cannot be run, or the program does not compile.
pub fn build_program(paths: &Paths, name: &str) -> Result<PathBuf, BuildError> {
    cargo_build(paths, &["--package", name, "--bin", name])?
        .into_iter()
        .filter(|artifact| artifact.target.name == name)
        .find_map(|artifact| artifact.executable)
        .map(cargo_metadata::camino::Utf8PathBuf::into_std_path_buf)
        .ok_or(BuildError::NoArtifact { package: name.to_owned(), what: "program" })
}

/// `cargo build` in the same target directory; progress and errors go to standard error.
fn cargo_build(paths: &Paths, arguments: &[&str]) -> Result<Vec<Artifact>, BuildError> {
    let program = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let mut command = Command::new(&program);
    command
        .current_dir(&paths.root)
        .args(["build", "--quiet", "--message-format=json-render-diagnostics"])
        .args(arguments)
        .arg("--target-dir")
        .arg(&paths.target);
    let output = command.output().map_err(|source| BuildError::Program {
        program: program.clone(),
        variable: "CARGO",
        source,
    })?;
    if !output.status.success() {
        return Err(BuildError::Refused {
            command: format!("{command:?}"),
            output: String::from_utf8_lossy(&output.stderr).into_owned(),
        });
    }
    let messages = Message::parse_stream(output.stdout.as_slice());
    Ok(messages
        .filter_map(|message| match message {
            Ok(Message::CompilerArtifact(artifact)) => Some(artifact),
            _ => None,
        })
        .collect())
}
