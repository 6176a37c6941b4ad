//! Projects of components, built as their authors build them.

mod add;
mod autotools;
mod bare;
mod genom3;
mod new;
mod rust;

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_tests::{copy_folder, program, repository};

/// An installation prefix with what components are built against.
struct Prefix {
    scratch: tempfile::TempDir,
}

impl Prefix {
    /// A prefix that `genomctl sdk` has filled, with the programs in it.
    fn new() -> Self {
        let prefix = Self { scratch: tempfile::tempdir().unwrap() };
        let bin = prefix.path().join("bin");
        fs::create_dir(&bin).unwrap();
        for name in ["genomd", "genomctl"] {
            // As installed: a program finds its prefix from where it is, links followed.
            if fs::hard_link(program(name), bin.join(name)).is_err() {
                fs::copy(program(name), bin.join(name)).unwrap();
            }
        }
        let out = prefix.run(Command::new(program("genomctl")).arg("sdk").arg(prefix.path()));
        assert!(out.contains("created "), "{out}");
        prefix
    }

    /// A package of types, as other projects install one.
    fn add_shapes(&self) {
        let shapes = repository().join("tests/fixtures/projects/shapes");
        let share = self.path().join("share");
        fs::create_dir_all(share.join("idl/shapes")).unwrap();
        fs::copy(shapes.join("shapes.idl"), share.join("idl/shapes/shapes.idl")).unwrap();
        fs::copy(shapes.join("shapes-idl.pc"), share.join("pkgconfig/shapes-idl.pc")).unwrap();
    }

    fn path(&self) -> &Path {
        self.scratch.path()
    }

    /// Directories of programs and packages, those of the prefix first.
    fn environment(&self, programs: &OsString) -> [(&'static str, OsString); 2] {
        let mut path = self.path().join("bin").into_os_string();
        path.push(":");
        path.push(programs);
        let packages = format!("{0}/share/pkgconfig:{0}/lib/pkgconfig", self.path().display());
        [("PATH", path), ("PKG_CONFIG_PATH", packages.into())]
    }

    /// What a command prints; it must succeed.
    #[track_caller]
    fn run(&self, command: &mut Command) -> String {
        let output = command.output().unwrap();
        let told = [output.stdout, output.stderr].concat();
        let told = String::from_utf8_lossy(&told).into_owned();
        assert!(output.status.success(), "{command:?}: {}\n{told}", output.status);
        told
    }
}

/// A copy of the fixture's folder, for a build to write into.
fn copied(name: &str, into: &Path) -> PathBuf {
    let to = into.join(name);
    copy_folder(&repository().join("tests/fixtures/projects").join(name), &to);
    to
}
