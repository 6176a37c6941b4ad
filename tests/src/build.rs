//! Programs and components under test, built once a test process.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use genom_components::{Artifact, Paths, build, build_programs};

/// Root of the repository.
#[must_use]
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the repository").to_owned()
}

fn paths() -> &'static Paths {
    static PATHS: OnceLock<Paths> = OnceLock::new();
    PATHS.get_or_init(|| Paths::of_workspace().unwrap_or_else(|error| panic!("{error}")))
}

/// `genomd` or `genomctl`, up to date.
#[must_use]
pub fn program(name: &str) -> PathBuf {
    static BUILT: OnceLock<[PathBuf; 2]> = OnceLock::new();
    let [genomd, genomctl] = BUILT.get_or_init(|| {
        build_programs(paths(), ["genomd", "genomctl"]).unwrap_or_else(|error| panic!("{error}"))
    });
    match name {
        "genomd" => genomd.clone(),
        "genomctl" => genomctl.clone(),
        other => panic!("{other} is no program of ours"),
    }
}

/// A component of the repository, up to date: its library, with its description beside it.
#[must_use]
pub fn component(name: &str) -> Artifact {
    build(paths(), name).unwrap_or_else(|error| panic!("{error}"))
}
