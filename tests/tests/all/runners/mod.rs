//! Runners that the configuration names, as docs/runners.md tells them.

mod configured;
mod words;
mod wrong;

use std::fs;
use std::path::{Path, PathBuf};

use genom_tests::{Home, path, repository};
use tempfile::TempDir;

/// A component whose codels only return events.
const DESCRIPTION: &str = r#"component toy {
  lang "words";
  ids { long n; };
  task main { period 10 ms; codel<start> toy_start() yield ether; };
  activity run() { task main; codel<start> toy_run() yield ether, other;
                   codel<other> toy_other() yield ether; };
};
"#;

/// A directory with a component, and its description there.
fn toy(description: &str, script: &str) -> (TempDir, PathBuf) {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("toy.gen");
    fs::write(&file, description).unwrap();
    fs::write(scratch.path().join("toy.words"), script).unwrap();
    (scratch, file)
}

/// A file of the example.
fn example(name: &str) -> PathBuf {
    repository().join("tests/fixtures/words").join(name)
}

/// For a daemon that runs codels in Words by this program in Python, which finds no package but those
/// of Python itself.
fn home(runner: &Path) -> Home {
    let runner = path(runner);
    Home::new().configured(&format!(
        "[runners.words]\nextension = \"words\"\ncommand = [\"python3\", \"-I\", {runner:?}]\n"
    ))
}
