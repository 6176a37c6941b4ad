//! Descriptions for these tests.

use std::path::{Path, PathBuf};

use genom_description::diagnostic::render;
use genom_description::{Analysis, Options, read};

/// A path in the crate.
pub(crate) fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

/// A description that must be accepted.
pub(crate) fn accepted(path: &Path) -> Analysis {
    let analysis = read(&[path], &Options::default());
    let said = render::short(&analysis.diagnostics, &analysis.sources);
    assert!(!analysis.has_errors(), "{said}");
    analysis
}

/// The descriptions among the test data that have no error.
pub(crate) fn all_accepted() -> Vec<(PathBuf, Analysis)> {
    let folders = ["../description/tests/cases", "../description/tests/papers", "tests/tools"];
    let mut found = Vec::new();
    for folder in folders {
        let mut files: Vec<_> =
            std::fs::read_dir(path(folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
        files.sort();
        for file in files.into_iter().filter(|file| file.extension().is_some_and(|e| e == "gen")) {
            let analysis = read(&[&file], &Options::default());
            if !analysis.has_errors() {
                found.push((file, analysis));
            }
        }
    }
    assert!(found.len() >= 20, "only {} descriptions were accepted", found.len());
    found
}
