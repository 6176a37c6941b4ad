//! `genomctl new --lang rust`, built with cargo from what an installed genomd has.

use std::fs;
use std::path::Path;
use std::process::Command;

use genom_tests::{Running, program, repository};

use super::Prefix;

#[test]
fn a_new_component_in_rust_builds_runs_and_passes_its_test() {
    let prefix = Prefix::new();
    let scratch = tempfile::tempdir().unwrap();
    let command = |words: &[&str]| {
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).current_dir(scratch.path());
        let path = std::env::var_os("PATH").unwrap_or_default();
        // The crates that the macros need were fetched for this workspace.
        command.envs(prefix.environment(&path)).env("CARGO_NET_OFFLINE", "true");
        command.env_remove("CARGO_TARGET_DIR");
        command
    };
    let run = |words: &[&str]| prefix.run(&mut command(words));
    let told = run(&["genomctl", "new", "arm", "--lang", "rust"]);
    let library = "arm/target/debug/libarm_codels.so";
    assert!(told.contains("created arm/src/codels.rs\n"), "{told}");
    assert!(told.ends_with(&format!("genomctl build arm && genomd {library}\n")), "{told}");
    let built = run(&["genomctl", "build", "arm"]);
    assert!(!built.contains("warning"), "{built}");
    let moves = ["genomctl", "test", "arm/tests"];
    let tested = run(&moves);
    assert!(tested.ends_with("2 scenarios passed\n"), "{tested}");
    run(&["genomd", "--check", library]);

    // What is added goes into the sources and into the list of codels.
    let add = ["genomctl", "add", "-C", "arm"];
    run(&[&add[..], &["task", "plan", "--period", "20ms"]].concat());
    let told = run(&[
        &add[..],
        &["service", "go_to", "--activity", "--task", "plan", "--validate"],
        &["--in", "goal=double", "--in", "from=place", "--in", "gains=sequence<float, 4>"],
        &["--in", "fast=boolean", "--in", "name=string<16>", "--out", "to=place"],
    ]
    .concat());
    assert!(told.contains("added arm_go_to_check to arm/src/codels.rs\n"), "{told}");
    run(&["genomctl", "add", "-C", "arm", "service", "seen", "--attribute", "--out", "position"]);
    let built = run(&["genomctl", "build", "arm"]);
    assert!(!built.contains("warning"), "{built}");
    run(&["genomd", "--check", library]);
    run(&moves);

    // The description is in the library, and codels are compared with it.
    let description = scratch.path().join("arm/arm.gen");
    let text = fs::read_to_string(&description).unwrap();
    fs::write(&description, text.replace("(in double goal", "(in long goal")).unwrap();
    run(&["genomctl", "build", "arm"]);
    let refused = Running::start(&mut command(&["genomd", "--check", library])).finish();
    refused.expect_code(1).expect_err("arm_step").expect_err("goal");
}

#[test]
fn a_project_in_rust_needs_the_sdk_and_says_how_to_install_it() {
    let scratch = tempfile::tempdir().unwrap();
    let new = |more: &[&str]| {
        let mut command = Command::new(program("genomctl"));
        command.args(["new", "arm", "--lang", "rust"]).args(more).current_dir(scratch.path());
        Running::start(command.env("PKG_CONFIG", "/nowhere/pkg-config")).finish()
    };
    new(&[]).expect_code(1).expect_err("is not installed").expect_err("`genomctl sdk PREFIX`");
    new(&["--sdk", "nowhere"]).expect_code(2).expect_err("nowhere: no Cargo.toml there");
    assert!(!scratch.path().join("arm").exists());
    let mut sdk = Command::new(program("genomctl"));
    sdk.arg("sdk").arg(scratch.path().join("a \"b\""));
    Running::start(&mut sdk).finish().expect_code(0);
    new(&["--sdk", "a \"b\"/share/genomd/rust"]).expect_code(0);
    let manifest: toml::Table =
        fs::read_to_string(scratch.path().join("arm/Cargo.toml")).unwrap().parse().unwrap();
    let named = manifest["dependencies"]["genom"]["path"].as_str().unwrap();
    assert!(Path::new(named).is_absolute() && named.ends_with("a \"b\"/share/genomd/rust"));
    assert!(Path::new(named).join("derive/Cargo.toml").is_file());
}

#[test]
fn the_installed_crates_are_described_as_those_of_the_workspace() {
    let templates = repository().join("daemon/project/templates/sdk/rust");
    let read = |path: &Path| -> toml::Table { fs::read_to_string(path).unwrap().parse().unwrap() };
    let workspace = read(&repository().join("Cargo.toml"));
    let (package, versions) =
        (&workspace["workspace"]["package"], &workspace["workspace"]["dependencies"]);
    for (template, own) in [("genom.toml", "rust"), ("genom-derive.toml", "derive")] {
        let (template, own) = (
            read(&templates.join(template)),
            read(&repository().join("plugin-api").join(own).join("Cargo.toml")),
        );
        for key in ["edition", "rust-version", "license"] {
            assert_eq!(template["package"][key], package[key], "{key}");
        }
        for key in ["name", "description"] {
            assert_eq!(template["package"][key], own["package"][key], "{key}");
        }
        let names = |of: &toml::Table| -> Vec<String> {
            of["dependencies"].as_table().unwrap().keys().cloned().collect()
        };
        assert_eq!(names(&template), names(&own));
        for name in names(&own).iter().filter(|name| !name.starts_with("genom")) {
            assert_eq!(template["dependencies"][name], versions[name], "{name}");
        }
    }
}
