//! The repository's demo, built.
#![allow(dead_code)]

use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

use super::Scratch;

/// The root of the repository.
pub(crate) fn root() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// The demo in C, built with these options.
pub(crate) fn in_c(scratch: &Scratch, options: &[&str]) -> PathBuf {
    let directory = root().join("components/demo");
    let codels = directory.join("codels");
    let includes = format!("-I{}", directory.display());
    let sources = ["demo_codels.c", "demo_main_codels.c"].map(|name| codels.join(name));
    let sources = sources.iter().map(|path| path.to_str().expect("a path in UTF-8"));
    let arguments = ["-shared", "-fPIC", &includes].into_iter().chain(sources);
    let arguments: Vec<&str> = arguments.chain(options.iter().copied()).chain(["-lm"]).collect();
    scratch.cc("demo.so", "", &arguments)
}

/// The demo in Rust, built once.
pub(crate) fn in_rust() -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let build = || {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args(["build", "--quiet", "--offline", "--message-format", "json"]);
        cargo.args(["--package", "demo-rs", "--lib"]).current_dir(root());
        let output = cargo.output().expect("cargo runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let messages = String::from_utf8(output.stdout).expect("text");
        let library = messages.lines().rev().find_map(|line| {
            let message: serde_json::Value = serde_json::from_str(line).ok()?;
            let mut files =
                message["filenames"].as_array()?.iter().filter_map(|file| file.as_str());
            files.find(|file| file.ends_with(".so")).map(PathBuf::from)
        });
        library.expect("cargo names the library it built")
    };
    BUILT.get_or_init(build).clone()
}
