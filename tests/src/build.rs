//! Builds the programs and components under test, once per test process.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

use genom_components::{Artifact, Paths, Purpose, build, build_programs};

use crate::Running;

/// Root folder of the repository.
#[must_use]
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the repository").to_owned()
}

/// Files of the repository with an extension, sorted; without those that cargo, npm and git create.
///
/// # Panics
/// If there are none.
#[must_use]
pub fn files(extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut directories = vec![repository()];
    while let Some(directory) = directories.pop() {
        for entry in std::fs::read_dir(&directory).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if path.is_dir() && !name.starts_with('.') && name != "target" && name != "node_modules"
            {
                directories.push(path);
            } else if path.extension().is_some_and(|found| found == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    assert!(!found.is_empty(), "no .{extension} file under {}", repository().display());
    found
}

fn paths() -> &'static Paths {
    static PATHS: OnceLock<Paths> = OnceLock::new();
    PATHS.get_or_init(|| Paths::of_workspace().unwrap_or_else(|error| panic!("{error}")))
}

/// `genomd` built with `--release`, once [`release`] was called.
static RELEASE: OnceLock<PathBuf> = OnceLock::new();

/// Path of `genomd` or `genomctl`, after building it.
#[must_use]
pub fn program(name: &str) -> PathBuf {
    if let Some(genomd) = RELEASE.get() {
        return genomd.with_file_name(name);
    }
    static BUILT: OnceLock<[PathBuf; 3]> = OnceLock::new();
    // The third one is what genomd runs for codels in Lua.
    let [genomd, genomctl, _] = BUILT.get_or_init(|| {
        build_programs(paths(), ["genomd", "genomctl", "genom-lua"], Purpose::Test)
            .unwrap_or_else(|error| panic!("{error}"))
    });
    match name {
        "genomd" => genomd.clone(),
        "genomctl" => genomctl.clone(),
        other => panic!("{other} is no program of ours"),
    }
}

/// A component of the repository, after building it: its library with its description beside it.
#[must_use]
pub fn component(name: &str) -> Artifact {
    build(paths(), name, Purpose::Test).unwrap_or_else(|error| panic!("{error}"))
}

/// Builds a component of `tests/fixtures` in a directory, as its author would: header from the
/// description, then C compiler. Returns the path of the description there.
///
/// # Panics
/// If it cannot be built.
#[must_use]
pub fn fixture(folder: &str, name: &str, into: &Path) -> String {
    let source = repository().join("tests/fixtures").join(folder);
    for entry in std::fs::read_dir(&source).expect("the fixture is there") {
        let file = entry.expect("the fixture can be listed").path();
        if file.extension().is_some_and(|extension| extension == "gen") {
            let name = file.file_name().expect("a file has a name");
            std::fs::copy(&file, into.join(name)).expect("a file can be copied");
        }
    }
    let file = |extension: &str| format!("{name}.{extension}");
    let mut header = Command::new(program("genomctl"));
    header.arg("header").arg(into.join(file("gen")));
    let header = Running::start(&mut header).finish();
    header.expect_code(0);
    let types = into.join(format!("{name}_c_types.h"));
    std::fs::write(types, &header.out).expect("a file can be written");
    let mut compiler = Command::new("cc");
    compiler.args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-g", "-fPIC", "-shared"]);
    compiler.arg("-I").arg(repository().join("plugin-api/include")).arg("-I").arg(into);
    compiler.arg(source.join(file("c"))).arg("-o").arg(into.join(file("so")));
    Running::start(&mut compiler).finish().expect_code(0);
    path(&into.join(file("gen"))).to_owned()
}

/// Copies a folder with all below it.
///
/// # Panics
/// If something cannot be read or written.
pub fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).expect("a folder can be made");
    for entry in std::fs::read_dir(from).expect("the folder can be listed") {
        let from = entry.expect("the folder can be listed").path();
        let to = to.join(from.file_name().expect("a file has a name"));
        if from.is_dir() {
            copy_folder(&from, &to);
        } else {
            std::fs::copy(&from, &to).expect("a file can be copied");
        }
    }
}

/// A path as a command line argument.
#[must_use]
pub fn path(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Path of a release build of the daemon, as users build it, for benchmarks. From then on
/// [`program`] gives programs of that build.
///
/// # Panics
/// It does not build.
#[must_use]
pub fn release() -> PathBuf {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(repository()).args([
        "build",
        "--release",
        "-p",
        "genomd",
        "-p",
        "genomctl",
    ]);
    assert!(command.status().expect("cargo runs").success(), "genomd does not build");
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    RELEASE.get_or_init(|| repository().join(target).join("release/genomd")).clone()
}
