//! `genomctl new`, built with the CMake package.

use std::ffi::OsString;
use std::fs;
use std::process::Command;

use genom_components::python;
use genom_tests::program;

use super::Prefix;

/// CMake, Meson and their generator from the registry of Python's packages, autotools from Debian's.
fn programs() -> OsString {
    let packages = ["cmake==3.31.6", "meson==1.0.1", "ninja==1.11.1.4"];
    let python = python::environment(&packages).unwrap();
    let mut path = python.parent().unwrap().as_os_str().to_owned();
    path.push(":");
    path.push(genom_components::debian::autotools().unwrap());
    path
}

#[test]
fn a_new_component_builds_runs_and_passes_its_test() {
    let prefix = Prefix::new();
    let scratch = tempfile::tempdir().unwrap();
    let programs = programs();
    let run = |words: &[&str]| {
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).current_dir(scratch.path());
        command.envs(prefix.environment(&programs)).env("CMAKE_GENERATOR", "Ninja");
        prefix.run(command.env("CMAKE_PREFIX_PATH", prefix.path()))
    };
    for (name, language) in [("arm", "c"), ("leg", "c++")] {
        let told = run(&["genomctl", "new", name, "--lang", language]);
        assert!(told.contains(&format!("created {name}/{name}.gen\n")), "{told}");
        run(&["genomctl", "build", name]);
        let build = format!("{name}/build");
        let tested = run(&["ctest", "--test-dir", &build, "--output-on-failure"]);
        assert!(tested.contains("100% tests passed"), "{tested}");
        assert!(scratch.path().join(&build).join("compile_commands.json").is_file());
        run(&["cmake", "--install", &build, "--prefix", prefix.path().to_str().unwrap()]);
        // Found by its name below the prefix that genomd itself is in.
        run(&["genomd", "--check", name]);
    }
    // The header is written again when the description changes, and the library with it.
    let description = scratch.path().join("arm/arm.gen");
    let text = fs::read_to_string(&description).unwrap();
    fs::write(&description, text.replace("(in double goal", "(in long goal")).unwrap();
    let mut again = Command::new("genomctl");
    again.args(["build", "arm"]).current_dir(scratch.path());
    again.envs(prefix.environment(&programs)).env("CMAKE_PREFIX_PATH", prefix.path());
    let output = again.output().unwrap();
    let told = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(!output.status.success() && told.contains("conflicting types"), "{told}");
}

#[test]
fn a_new_component_may_be_built_by_meson_or_by_autotools() {
    let prefix = Prefix::new();
    let scratch = tempfile::tempdir().unwrap();
    let programs = programs();
    let run = |words: &[&str]| {
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).current_dir(scratch.path());
        prefix.run(command.envs(prefix.environment(&programs)))
    };
    let install = prefix.path().join("installed");
    for (tool, language, name, test) in [
        ("meson", "c", "arm", &["meson", "test", "-C", "arm/build"][..]),
        ("meson", "c++", "leg", &["meson", "test", "-C", "leg/build"]),
        ("autotools", "c", "hand", &["make", "-C", "hand/build", "check"]),
        ("autotools", "c++", "foot", &["make", "-C", "foot/build", "check"]),
    ] {
        run(&["genomctl", "new", name, "--lang", language, "--with", tool]);
        run(&["genomctl", "build", name]);
        // Either of the two finds the other.
        run(&["genomd", "--check", &format!("{name}/{name}.gen")]);
        let readme = fs::read_to_string(scratch.path().join(name).join("README.md")).unwrap();
        let library = readme.split("genomd ").nth(1).unwrap();
        let library = library.split_whitespace().next().unwrap();
        run(&["genomd", "--check", &format!("{name}/{library}")]);
        let tested = run(test);
        assert!(!tested.contains("FAIL"), "{tested}");
        assert!(readme.contains(&test.join(" ").replace(&format!("{name}/"), "")), "{readme}");
    }
    let built = scratch.path().join("hand/build");
    let prefix_of_hand = format!("prefix={}", install.display());
    run(&["make", "-C", &built.to_string_lossy(), "install", &prefix_of_hand]);
    run(&["genomd", "--path", &install.to_string_lossy(), "--check", "hand"]);
    run(&["meson", "configure", "arm/build", &format!("-Dprefix={}", install.display())]);
    run(&["meson", "install", "-C", "arm/build"]);
    // In lib/genomd, or where this machine has libraries.
    let found = [
        "lib/genomd",
        "lib64/genomd",
        "lib/x86_64-linux-gnu/genomd",
        "lib/aarch64-linux-gnu/genomd",
    ]
    .map(|place| install.join(place).join("arm.so"));
    assert!(found.iter().any(|library| library.is_file()), "{found:?}");
}

#[test]
fn nothing_is_written_over_what_is_there_nor_under_a_name_that_no_component_can_have() {
    let scratch = tempfile::tempdir().unwrap();
    let new = |arguments: &[&str]| {
        let mut command = Command::new(program("genomctl"));
        command.arg("new").args(arguments).current_dir(scratch.path()).output().unwrap()
    };
    assert!(new(&["arm"]).status.success());
    fs::write(scratch.path().join("arm/arm.gen"), "mine").unwrap();
    let refused = new(&["arm"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&refused.stderr).contains("arm/arm.gen exists already"));
    assert_eq!(fs::read_to_string(scratch.path().join("arm/arm.gen")).unwrap(), "mine");
    let refused = new(&["my-arm"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(!scratch.path().join("my-arm").exists());
    let refused = new(&["wheel", "--lang", "rust", "--with", "meson"]);
    assert_eq!(refused.status.code(), Some(2));
    let told = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert!(told.contains("cargo builds components in Rust"), "{told}");
}
