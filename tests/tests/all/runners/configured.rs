//! A language that genomd does not know: the configuration names its runner.

use std::fs;

use genom_tests::{Home, path};

use super::{DESCRIPTION, example, home, toy};

const SCRIPT: &str = "toy_start:\n yield ether\ntoy_run:\n yield other\ntoy_other:\n yield ether\n";

#[test]
fn codels_in_a_language_of_the_configuration_run() {
    let (scratch, file) = toy(DESCRIPTION, SCRIPT);
    let daemon = home(&example("runner.py")).start(&[path(&file)]);
    let mut events = daemon.events();
    let call = daemon.spawn(&["call", "toy", "run"]);
    events.wait_for(|e| e["event"] == "transition" && e["state"] == "other");
    call.finish().expect_code(0);
    fs::write(scratch.path().join("toy.words"), "toy_start:\n yield ether\n").unwrap();
    let refused = daemon.ctl(&["reload", "toy"]);
    refused.expect_code(1).expect_err("toy.words: codel `toy_run` (").expect_err(") is missing");
    daemon.ctl(&["call", "toy", "run"]).expect_code(0);
}

#[test]
fn a_script_in_such_a_language_is_checked() {
    let (_scratch, file) = toy(DESCRIPTION, "toy_start:\n yield ether\n");
    let refused = home(&example("runner.py")).refused(&["--check", path(&file)]);
    refused.expect_code(1).expect_err("toy.words: codel `toy_run` (").expect_err(") is missing");
}

#[test]
fn a_runner_that_is_no_program_is_named_by_its_key() {
    let (_scratch, file) = toy(DESCRIPTION, SCRIPT);
    let config = "[runners.words]\nextension = \"words\"\ncommand = [\"/nowhere/runner\"]\n\
                  [cells]\nrestart_most = 0\n";
    let refused = Home::new().configured(config).refused(&["--check", path(&file)]);
    refused.expect_code(1).expect_err("`/nowhere/runner` does not run");
    refused.expect_err("runners.words.command names the interpreter");
    let started = Home::new().configured(config).refused(&[path(&file)]);
    started.expect_code(1).expect_err("/nowhere/runner: No such file");
}

#[test]
fn a_section_of_no_runner_is_refused() {
    for (config, told) in [
        ("[runners.words]\ncommand = [\"words\"]\n", "runners.words: extension"),
        ("[runners.python]\ncommand = [\"python3\"]\n", "cells.python names it"),
        ("[runners.words]\nextension = \"so\"\ncommand = [\"words\"]\n", "none of so"),
    ] {
        let refused = Home::new().configured(config).refused(&[]);
        refused.expect_code(2).expect_err(told);
    }
}
