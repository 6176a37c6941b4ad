//! Every component is built once, whoever asks, and placed where users look for it.

#![allow(clippy::unwrap_used, reason = "it is a test")]

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::SystemTime;

use genom_components::{BuildError, Paths, Purpose, build, build_all};

fn dates(paths: &Paths) -> BTreeMap<PathBuf, SystemTime> {
    build_all(paths, Purpose::Test)
        .unwrap()
        .into_iter()
        .flat_map(|artifact| [artifact.library, artifact.description])
        .map(|file| {
            let date = file.metadata().unwrap().modified().unwrap();
            (file, date)
        })
        .collect()
}

#[test]
fn every_component_lies_with_its_description_under_target() {
    let paths = Paths::of_workspace().unwrap();
    let built = build_all(&paths, Purpose::Test).unwrap();
    let names: Vec<_> = built.iter().map(|artifact| artifact.name.as_str()).collect();
    assert!(names.starts_with(&["demo", "demo-2010", "demo-2011", "demo-rs"]), "{names:?}");
    let components = paths.target.join("components");
    assert!(components.join("demo/demo.so").is_file());
    assert!(components.join("demo-rs/demo-rs.gen").is_file());
    assert!(components.join("demo-2011/demo-types.idl").is_file());
    assert!(components.join("images/images.idl").is_file());
    for artifact in built {
        assert_eq!(artifact.library.parent().unwrap(), components.join(&artifact.name));
        assert_eq!(artifact.library.with_extension("gen"), artifact.description);
    }
}

#[test]
fn what_is_up_to_date_is_not_built_again() {
    let paths = Paths::of_workspace().unwrap();
    assert_eq!(dates(&paths), dates(&paths));
}

#[test]
fn several_builds_at_once_agree() {
    // A target directory of its own, so that everything has to be built; without components in
    // Rust.
    let target = tempfile::tempdir().unwrap();
    let root = Paths::of_workspace().unwrap().root;
    let paths = Paths { root, target: target.path().to_owned() };
    let libraries: Vec<_> = std::thread::scope(|scope| {
        let builds: Vec<_> =
            (0..4).map(|_| scope.spawn(|| build(&paths, "demo", Purpose::Test))).collect();
        builds.into_iter().map(|build| build.join().unwrap().unwrap().library).collect()
    });
    assert!(libraries.iter().all(|library| *library == libraries[0] && library.is_file()));
}

#[test]
fn a_changed_source_is_built_again_and_an_error_names_the_line() {
    let workspace = Paths::of_workspace().unwrap();
    let copy = tempfile::tempdir().unwrap();
    let root = copy.path();
    let components = [
        "demo", "demo-cpp", "demo-py", "demo-lua", "mission", "images", "camera", "stereo",
        "viewer", "sim", "servo", "hover", "planner",
    ];
    let components = components.map(|name| format!("components/{name}"));
    for folder in components.iter().map(String::as_str).chain(["plugin-api/include"]) {
        copy_folder(&workspace.root.join(folder), &root.join(folder));
    }
    let paths = Paths { root: root.to_owned(), target: root.join("target") };
    let library = build(&paths, "demo", Purpose::Test).unwrap().library;
    let before = std::fs::read(&library).unwrap();

    let limits = root.join("components/demo/codels/demo_limits.h");
    let text = std::fs::read_to_string(&limits).unwrap();
    std::fs::write(&limits, text.replace("DEMO_SPEED_MAX 2.0 ", "DEMO_SPEED_MAX 3.25")).unwrap();
    build(&paths, "demo", Purpose::Test).unwrap();
    assert_ne!(std::fs::read(&library).unwrap(), before, "a header is an input");

    let source = root.join("components/demo/codels/demo_codels.c");
    std::fs::write(&source, "int broken(void) { return }\n").unwrap();
    let error = build(&paths, "demo", Purpose::Test).unwrap_err();
    assert!(matches!(error, BuildError::Refused { .. }));
    assert!(error.to_string().contains("demo_codels.c:1:"), "{error}");
    assert!(library.is_file(), "the last good library stays");
}

#[test]
fn an_unknown_component_lists_those_that_exist() {
    let error = build(&Paths::of_workspace().unwrap(), "dmo", Purpose::Test).unwrap_err();
    let text = "no component is called `dmo`; there are demo, demo-2010, demo-2011, demo-rs";
    assert!(error.to_string().starts_with(text), "{error}");
}

fn copy_folder(from: &std::path::Path, to: &std::path::Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &to);
        } else {
            std::fs::copy(entry.path(), &to).unwrap();
        }
    }
}
