//! Python environments with pinned packages, for tests against peers that are not genomd.
//!
//! An environment is created once under the target directory and then reused. If it cannot be
//! created, that is an error: tests are not skipped for lack of a peer.

use std::ffi::OsString;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{BuildError, Paths};

/// The interpreter of an environment that contains these packages, given as `name==version`.
///
/// The first call installs them, which needs the network. Several processes may call it at once.
/// `$PYTHON` selects an interpreter other than `python3`.
///
/// # Errors
/// There is no Python, it lacks `venv`, or a package cannot be installed.
pub fn environment(packages: &[&str]) -> Result<PathBuf, BuildError> {
    let name: Vec<_> = packages.iter().map(|package| package.replace("==", "-")).collect();
    let place = made_once(&name.join("+"), |place| {
        let variable = std::env::var_os("PYTHON");
        let base = variable.unwrap_or_else(|| OsString::from("python3"));
        run(Command::new(base).args(["-m", "venv", "--clear"]).arg(place))?;
        let pip = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
        run(Command::new(place.join("bin/python")).args(pip).args(packages))
    })?;
    Ok(place.join("bin/python"))
}

/// A directory of this name, created by the first caller. A creation that was interrupted is
/// started again.
pub(crate) fn made_once(
    name: &str,
    make: impl FnOnce(&Path) -> Result<(), BuildError>,
) -> Result<PathBuf, BuildError> {
    let directory = Paths::of_workspace()?.target.join("python").join(name);
    std::fs::create_dir_all(&directory).map_err(BuildError::file(&directory))?;
    let path = directory.join(".lock");
    let lock = File::create(&path).map_err(BuildError::file(&path))?;
    lock.lock().map_err(BuildError::file(&path))?;
    let place = directory.join("env");
    let complete = directory.join("complete");
    if !complete.exists() {
        make(&place)?;
        std::fs::write(&complete, name).map_err(BuildError::file(&complete))?;
    }
    Ok(place)
}

pub(crate) fn run(command: &mut Command) -> Result<(), BuildError> {
    let program = Path::new(command.get_program()).display().to_string();
    let output = command.output().map_err(|source| BuildError::Program {
        program,
        variable: "PYTHON",
        source,
    })?;
    if output.status.success() {
        return Ok(());
    }
    let told = [output.stdout, output.stderr].concat();
    Err(BuildError::Refused {
        command: format!("{command:?}"),
        output: String::from_utf8_lossy(&told).into_owned(),
    })
}
