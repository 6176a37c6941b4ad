//! Every description of the repository is read without errors or warnings.

#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::path::{Path, PathBuf};

use genom_description::diagnostic::{Severity, render};
use genom_description::{Options, read};

fn descriptions(directory: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(directory).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            descriptions(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "gen") {
            found.push(path);
        }
    }
}

#[test]
fn the_descriptions_of_the_repository_have_no_errors() {
    let mut found = Vec::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../components");
    descriptions(&root, &mut found);
    assert!(found.iter().any(|path| path.ends_with("demo/demo.gen")), "{found:?}");
    for path in found {
        let analysis = read(&[&path], &Options::default());
        let said = render::short(&analysis.diagnostics, &analysis.sources);
        let errors = analysis.diagnostics.iter().filter(|d| d.severity == Severity::Error);
        assert_eq!(errors.count(), 0, "{said}");
        assert_eq!(analysis.specification.components.len(), 1, "{}", path.display());
        println!("{}: {said}", path.display());
    }
}
