//! Builds libraries of codels in Rust, and programs of the workspace, with cargo.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use cargo_metadata::{Artifact, CrateType, Message};

use crate::error::BuildError;
use crate::paths::{Paths, copy_if_changed};
use crate::recipe::Recipe;

/// Builds `library` from the package that has the recipe's name.
pub(crate) fn library(
    paths: &Paths,
    recipe: &Recipe,
    library: &Path,
    purpose: Purpose,
) -> Result<(), BuildError> {
    let selection: &[&str] = match purpose {
        Purpose::Use => &["--package", &recipe.name],
        Purpose::Test => &TESTED,
    };
    let artifacts = cargo_build(paths, Progress::Kept, selection)?;
    let built = artifacts
        .iter()
        .filter(|artifact| artifact.target.crate_types.contains(&CrateType::CDyLib))
        .filter(|artifact| artifact.target.name == recipe.name.replace('-', "_"))
        .flat_map(|artifact| &artifact.filenames)
        .find(|file| file.extension() == Some("so"));
    let Some(built) = built else {
        return Err(BuildError::NoArtifact { package: recipe.name.clone(), what: "cdylib" });
    };
    copy_if_changed(built.as_std_path(), library)
}

/// All libraries, with the features that tests ask for: with those of any one test, here that of the
/// package that has this file.
const TESTED: [&str; 4] = ["--workspace", "--test", "builds", "--lib"];

/// What programs and libraries of codels are built for.
///
/// Cargo gives dependencies the features that all packages of one build ask for, with those of
/// tests if there is a test among them. Other packages mean other features, and that zenoh,
/// iceoryx2 and others are compiled once more, which takes minutes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// To be used: with the features that the programs themselves ask for.
    Use,
    /// To be tested: with the features that `cargo test --workspace` has compiled already.
    Test,
}

/// Builds programs of the workspace, each from the package of its name, and returns their paths.
///
/// This may take minutes; cargo's progress goes to standard error.
///
/// # Errors
/// Cargo cannot be run, or a program does not compile.
pub fn build_programs<const N: usize>(
    paths: &Paths,
    names: [&str; N],
    purpose: Purpose,
) -> Result<[PathBuf; N], BuildError> {
    let (option, mut arguments) = match purpose {
        Purpose::Use => ("--package", Vec::new()),
        // A library is what cells with codels in scripts load, beside the programs.
        Purpose::Test => ("--bin", TESTED.to_vec()),
    };
    arguments.extend(names.iter().flat_map(|name| [option, *name]));
    let artifacts = cargo_build(paths, Progress::Shown, &arguments)?;
    let mut programs = std::array::from_fn(|_| PathBuf::new());
    for (name, program) in names.iter().zip(&mut programs) {
        *program = artifacts
            .iter()
            .filter(|artifact| artifact.target.name == *name)
            .find_map(|artifact| artifact.executable.as_deref())
            .map(|path| path.as_std_path().to_owned())
            .ok_or_else(|| BuildError::NoArtifact {
                package: (*name).to_owned(),
                what: "program",
            })?;
    }
    Ok(programs)
}

/// Where cargo's standard error goes.
enum Progress {
    /// To the user.
    Shown,
    /// Into the error, if there is one.
    Kept,
}

/// Runs `cargo build` with the target directory of this build.
fn cargo_build(
    paths: &Paths,
    progress: Progress,
    arguments: &[&str],
) -> Result<Vec<Artifact>, BuildError> {
    let program = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let mut command = Command::new(&program);
    command
        .current_dir(&paths.root)
        .args(["build", "--message-format=json-render-diagnostics"])
        .args(arguments)
        .arg("--target-dir")
        .arg(&paths.target)
        .stdin(Stdio::null());
    // Removes variables that the Cargo running a test sets for the test's package: build scripts
    // that depend on them (ring's) would otherwise run again, and everything that depends on them
    // be rebuilt.
    for (variable, _) in std::env::vars_os() {
        let name = variable.to_string_lossy();
        if name == "OUT_DIR"
            || ["CARGO_PKG_", "CARGO_MANIFEST_"].iter().any(|own| name.starts_with(own))
        {
            command.env_remove(&variable);
        }
    }
    match progress {
        Progress::Shown => command.stderr(Stdio::inherit()),
        Progress::Kept => command.arg("--quiet").stderr(Stdio::piped()),
    };
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
