//! Compiles small C and C++ libraries into a directory that is removed with the test.
#![allow(dead_code)]
#![allow(clippy::expect_used, clippy::panic, clippy::unwrap_used)] // helpers of tests

pub(crate) mod cxx;
pub(crate) mod demo;
#[path = "gen.rs"]
pub(crate) mod generator;
pub(crate) mod load;

use std::path::{Path, PathBuf};
use std::process::Command;

/// A directory for one test.
pub(crate) struct Scratch(tempfile::TempDir);

impl Scratch {
    /// A new, empty one.
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().expect("a temporary directory"))
    }

    /// Its path.
    pub(crate) fn path(&self) -> &Path {
        self.0.path()
    }

    /// A file with these contents.
    pub(crate) fn file(&self, name: &str, contents: &[u8]) -> PathBuf {
        let path = self.path().join(name);
        std::fs::write(&path, contents).expect("a file written");
        path
    }

    /// A shared library of this C source.
    pub(crate) fn library(&self, name: &str, source: &str) -> PathBuf {
        self.cc(name, source, &["-shared", "-fPIC"])
    }

    /// Compiles C source with `cc`; returns the output.
    pub(crate) fn cc(&self, name: &str, source: &str, arguments: &[&str]) -> PathBuf {
        self.compile("cc", "c", name, source, arguments)
    }

    /// Compiles C++ source with `c++`; returns the output.
    pub(crate) fn cxx(&self, name: &str, source: &str, arguments: &[&str]) -> PathBuf {
        self.compile("c++", "cc", name, source, arguments)
    }

    fn compile(
        &self,
        compiler: &str,
        suffix: &str,
        name: &str,
        source: &str,
        arguments: &[&str],
    ) -> PathBuf {
        let output = self.path().join(name);
        let input = output.with_extension(suffix);
        std::fs::write(&input, source).expect("a source written");
        let mut command = Command::new(compiler);
        command.args(["-g", "-O1", "-Wall", "-o"]).arg(&output).arg(&input);
        command.arg(concat!("-I", env!("CARGO_MANIFEST_DIR"), "/../../plugin-api/include"));
        command.args(arguments);
        let done = command.output().expect("a C compiler");
        assert!(
            done.status.success(),
            "{compiler} failed on {name}:\n{}",
            String::from_utf8_lossy(&done.stderr)
        );
        output
    }
}
