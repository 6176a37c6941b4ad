//! Scripts that do not fit their description are refused before anything of them runs.

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt as _;

use genom_tests::{Home, path};
use tempfile::TempDir;

use super::{DESCRIPTION, SCRIPT, axis};

/// What is told of a script, by a daemon that is to run it and by one that only checks.
#[track_caller]
fn refused(description: &str, script: &str, told: &[&str]) {
    let (_scratch, file) = axis(description, script);
    for check in [&["--check"][..], &[]] {
        let refused = Home::new().refused(&[check, &[path(&file)]].concat());
        refused.expect_code(1);
        told.iter().for_each(|told| _ = refused.expect_err(told));
    }
}

#[test]
fn wrong_names_arguments_and_results_are_told_with_the_lines_of_both_files() {
    let script = SCRIPT
        .replace("def axis_stop(what)", "def axis_sotp(what)")
        .replace("def axis_run(what, at)", "def axis_run(what, att: int)")
        .replace("return \"ether\"\n\n\ndef axis_how", "return \"eter\"\n\n\ndef axis_how");
    assert_ne!(script, SCRIPT);
    refused(
        DESCRIPTION,
        &script,
        &[
            "axis.py: codel `axis_stop` (",
            "axis.gen:18) is not defined; did you mean `axis_sotp`?",
            "axis.gen:17), line 35: the description has no parameter `att`; did you mean `at`?",
            "axis.gen:9), line 9: it returns 'eter'; it may yield ether",
        ],
    );
}

#[test]
fn a_script_that_does_not_run_is_told_with_its_line() {
    let missing = format!("{SCRIPT}import no_such_module\n");
    refused(DESCRIPTION, &missing, &["axis.py: line 55: ModuleNotFoundError"]);
    refused(DESCRIPTION, "def axis_start(:\n", &["axis.py: line 1: invalid syntax"]);
    refused(DESCRIPTION, "import os\nraise SystemExit(0)\n", &["axis.py: line 2: SystemExit: 0"]);
}

#[test]
fn description_and_file_agree_on_the_language() {
    let in_c = DESCRIPTION.replace("\"python\"", "\"c\"");
    refused(&in_c, SCRIPT, &["its codels are in python, but component `axis`", "has lang \"c\""]);
}

#[test]
fn an_interpreter_that_is_none_is_named() {
    let (_scratch, file) = axis(DESCRIPTION, SCRIPT);
    let config = "[cells]\npython = \"/nowhere/python\"\nrestart_most = 0\n";
    let home = || Home::new().configured(config);
    let refused = home().refused(&["--check", path(&file)]);
    refused.expect_code(1).expect_err("`/nowhere/python` does not run");
    refused.expect_err("cells.python names the interpreter");
    home().refused(&[path(&file)]).expect_code(1).expect_err("/nowhere/python: No such file");
}

/// A configuration with an interpreter of its own, which a shell starts.
fn interpreter(scratch: &TempDir, start: &str) -> String {
    let interpreter = scratch.path().join("python");
    fs::write(&interpreter, format!("#!/bin/sh\n{start} \"$@\"\n")).unwrap();
    fs::set_permissions(&interpreter, Permissions::from_mode(0o755)).unwrap();
    format!("[cells]\npython = {:?}\n", path(&interpreter))
}

#[test]
fn an_interpreter_without_the_package_is_told_and_not_tried_again() {
    let (scratch, file) = axis(DESCRIPTION, SCRIPT);
    // It sees no packages but those of Python.
    let config = interpreter(&scratch, "exec python3 -I -S");
    let told = format!("which has no package genom {}: install it", env!("CARGO_PKG_VERSION"));
    for check in [&["--check"][..], &[]] {
        let home = Home::new().configured(&config);
        let refused = home.refused(&[check, &[path(&file)]].concat());
        refused.expect_code(1).expect_err(&told);
        assert!(!refused.err.contains("restarted in"), "{}", refused.err);
    }
}

#[test]
fn another_version_of_the_package_is_told_and_not_tried_again() {
    let (scratch, file) = axis(DESCRIPTION, SCRIPT);
    let package = scratch.path().join("genom");
    let source = genom_tests::repository().join("clients/python/src/genom");
    genom_tests::copy_folder(&source, &package);
    let init = package.join("__init__.py");
    let text = fs::read_to_string(&init).unwrap();
    let version = format!("__version__ = \"{}\"", env!("CARGO_PKG_VERSION"));
    assert!(text.contains(&version));
    fs::write(&init, text.replace(&version, "__version__ = \"0.0.9\"")).unwrap();
    let config =
        interpreter(&scratch, &format!("PYTHONPATH={} exec python3", path(scratch.path())));
    let refused = Home::new().configured(&config).refused(&[path(&file)]);
    refused
        .expect_code(1)
        .expect_err("this Python has the package genom 0.0.9: pip install genom==");
    assert!(!refused.err.contains("restarted in"), "{}", refused.err);
}
