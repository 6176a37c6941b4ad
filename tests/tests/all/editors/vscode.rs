//! The extension for Visual Studio Code, packaged by its usual tool.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use genom_components::node;
use genom_tests::{program, repository};

fn source() -> PathBuf {
    repository().join("docs/editors/vscode")
}

/// Runs a script of the package as the page says.
#[track_caller]
fn npm(directory: &Path, script: &str) {
    let path = node::path().unwrap_or_else(|error| panic!("{error}"));
    let roots = ["components", "plugin-api", "daemon/description/tests/model", "tests/fixtures"];
    let roots = roots.map(|root| repository().join(root));
    let mut command = Command::new("npm");
    command.args(["run", script]).current_dir(directory).env("PATH", path);
    command.env("GENOMCTL", program("genomctl"));
    command.env("GENOM_DESCRIPTIONS", std::env::join_paths(roots).unwrap());
    let output = command.output().unwrap();
    let told = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "npm run {script}:\n{}", String::from_utf8_lossy(&told));
}

#[test]
fn the_extension_is_packaged_and_passes_its_tests_and_those_of_its_grammar() {
    let scratch = tempfile::tempdir().unwrap();
    let directory = scratch.path().join("vscode");
    node::package(&source(), &directory).unwrap_or_else(|error| panic!("{error}"));
    npm(&directory, "package");
    let mut list = Command::new("python3");
    list.args(["-c", LIST]).arg(directory.join("genom.vsix"));
    let files = String::from_utf8(list.output().unwrap().stdout).unwrap();
    let files: Vec<&str> = files.lines().collect();
    assert_eq!(files, PACKAGED);
    npm(&directory, "test");
}

const LIST: &str = "import sys, zipfile
print(*sorted(zipfile.ZipFile(sys.argv[1]).namelist()), sep='\\n')";

/// All that users get.
const PACKAGED: [&str; 9] = [
    "[Content_Types].xml",
    "extension.vsixmanifest",
    "extension/LICENSE.txt",
    "extension/dist/extension.js",
    "extension/gen.tmLanguage.json",
    "extension/language-configuration.json",
    "extension/package.json",
    "extension/readme.md",
    "extension/snippets.json",
];

#[test]
fn the_extension_has_the_version_and_a_licence_of_the_project() {
    let read = |path: PathBuf| fs::read_to_string(path).unwrap();
    let package: serde_json::Value =
        serde_json::from_str(&read(source().join("package.json"))).unwrap();
    let workspace: toml::Table = read(repository().join("Cargo.toml")).parse().unwrap();
    let workspace = &workspace["workspace"]["package"];
    for key in ["version", "license"] {
        assert_eq!(package[key].as_str(), workspace[key].as_str(), "{key}");
    }
    assert_eq!(read(source().join("LICENSE")), read(repository().join("LICENSE-MIT")));
}
