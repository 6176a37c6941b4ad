//! The components in README.md are written to files, built and run as it says.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use genom_components::Paths;
use genom_tests::{Daemon, WATCHDOG, path, repository};
use tempfile::TempDir;

/// The fenced block of README.md that contains `text`.
#[track_caller]
fn block(text: &str) -> String {
    let readme = std::fs::read_to_string(repository().join("README.md")).unwrap();
    let blocks = readme.split("```").skip(1).step_by(2);
    let found = blocks.filter_map(|block| block.split_once('\n')).find(|(_, b)| b.contains(text));
    found.unwrap_or_else(|| panic!("README.md shows no block with `{text}`")).1.to_owned()
}

#[track_caller]
fn run(command: &mut Command) {
    let output = command.output().expect("the program runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// Checks that the lamp switches every half second.
fn blinks(library: &Path) {
    let daemon = Daemon::start(&[path(library)]);
    let lamp = || daemon.ctl(&["call", "blink", "get"]).expect_code(0).out.clone();
    let first = lamp();
    assert!(["on = true\n", "on = false\n"].contains(&first.as_str()), "{first}");
    let deadline = Instant::now() + WATCHDOG;
    while lamp() == first {
        assert!(Instant::now() < deadline, "the lamp does not change");
    }
}

#[test]
fn the_component_in_c_runs() {
    let scratch = TempDir::new().unwrap();
    std::fs::write(scratch.path().join("blink.gen"), block("component blink {")).unwrap();
    std::fs::write(scratch.path().join("blink_codels.c"), block("GENOM_DESCRIPTION")).unwrap();
    let library = scratch.path().join("blink.so");
    let compile = block("-o blink.so").lines().next().unwrap().to_owned();
    let compile = compile.replace("plugin-api", path(&repository().join("plugin-api")));
    run(Command::new("sh").current_dir(scratch.path()).args(["-c", &compile]));
    blinks(&library);
}

#[test]
fn the_component_in_rust_runs() {
    let scratch = TempDir::new().unwrap();
    let root = scratch.path();
    std::fs::create_dir(root.join("src")).unwrap();
    std::fs::write(root.join("src/blink.gen"), block("component blink {")).unwrap();
    std::fs::write(root.join("src/lib.rs"), block("genom::component!")).unwrap();
    let manifest = format!(
        "[package]\nname = \"blink\"\nversion = \"0.0.0\"\nedition = \"2024\"\n\n[lib]\n\
         crate-type = [\"cdylib\"]\n\n[dependencies]\ngenom = {{ path = {:?} }}\n\n[workspace]\n",
        repository().join("plugin-api/rust"),
    );
    std::fs::write(root.join("Cargo.toml"), manifest).unwrap();
    // Uses the versions of dependencies that are already there.
    std::fs::copy(repository().join("Cargo.lock"), root.join("Cargo.lock")).unwrap();
    let target = Paths::of_workspace().unwrap().target.join("readme");
    let mut build = Command::new(env!("CARGO"));
    run(build.args(["build", "--quiet", "--target-dir"]).arg(&target).current_dir(root));
    blinks(&target.join("debug/libblink.so"));
}
