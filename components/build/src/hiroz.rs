//! A node of ROS 2 over zenoh for tests, made with hiroz, an implementation in Rust that is not ours.

use std::ffi::OsString;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::Path;
use std::process::Command;

use crate::BuildError;
use crate::paths::Paths;
use crate::python::{made_once, run};

/// A process that runs the node, for [`Peer`](crate::peer::Peer), at the router of this endpoint;
/// `hiroz/src/main.rs` lists its commands, and what other arguments it takes. The first caller builds
/// it, which takes minutes.
///
/// # Errors
/// It does not compile, or its crates cannot be fetched.
pub fn node(router: &str) -> Result<Command, BuildError> {
    let project = Paths::of_workspace()?.root.join("components/build/hiroz");
    let mut hash = DefaultHasher::new();
    let sources = project.join("src");
    let sources = sources.read_dir().map_err(BuildError::file(&sources))?;
    let mut files: Vec<_> = sources.flatten().map(|entry| entry.path()).collect();
    files.extend(["Cargo.lock", "Cargo.toml"].map(|name| project.join(name)));
    files.sort();
    for path in files {
        std::fs::read(&path).map_err(BuildError::file(&path))?.hash(&mut hash);
    }
    let place =
        made_once(&format!("hiroz-{:016x}", hash.finish()), |place| built(&project, place))?;
    let mut command = Command::new(place.join("hiroz-peer"));
    command.arg(router);
    Ok(command)
}

/// Only the program is kept: what it was built from takes a gigabyte.
fn built(project: &Path, place: &Path) -> Result<(), BuildError> {
    let target = place.join("target");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| OsString::from("cargo"));
    let mut build = Command::new(cargo);
    build.args(["build", "--quiet", "--locked", "--manifest-path"]).arg(project.join("Cargo.toml"));
    build.arg("--target-dir").arg(&target).env("CARGO_INCREMENTAL", "0");
    run(&mut build)?;
    let program = place.join("hiroz-peer");
    std::fs::rename(target.join("debug/hiroz-peer"), &program)
        .map_err(BuildError::file(&program))?;
    std::fs::remove_dir_all(&target).map_err(BuildError::file(&target))
}
