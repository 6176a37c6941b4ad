//! A language that genomd does not know: the configuration names its runner.

use std::fs;
use std::path::Path;

use genom_tests::{Home, path, repository};
use tempfile::TempDir;

const DESCRIPTION: &str = r#"component toy {
  lang "words";
  ids { long n; };
  task main { period 10 ms; codel<start> toy_start() yield ether; };
  activity run() { task main; codel<start> toy_run() yield ether, other;
                   codel<other> toy_other() yield ether; };
};
"#;

/// Each line is a codel and what it returns.
const SCRIPT: &str = "toy_start ether\ntoy_run other\ntoy_other ether\n";

fn toy(script: &str) -> (TempDir, Home) {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("toy.gen"), DESCRIPTION).unwrap();
    fs::write(scratch.path().join("toy.words"), script).unwrap();
    let runner = repository().join("tests/fixtures/words_runner.py");
    let config = format!(
        "[runners.words]\nextension = \"words\"\ncommand = [\"python3\", {:?}]\n",
        path(&runner)
    );
    let home = Home::new().configured(&config);
    (scratch, home)
}

fn gen_file(directory: &Path) -> String {
    path(&directory.join("toy.gen")).to_owned()
}

#[test]
fn codels_in_a_language_of_the_configuration_run() {
    let (scratch, home) = toy(SCRIPT);
    let daemon = home.start(&[&gen_file(scratch.path())]);
    let mut events = daemon.events();
    let call = daemon.spawn(&["call", "toy", "run"]);
    events.wait_for(|e| e["event"] == "transition" && e["state"] == "other");
    call.finish().expect_code(0);
    fs::write(scratch.path().join("toy.words"), "toy_start ether\n").unwrap();
    daemon.ctl(&["reload", "toy"]).expect_code(1).expect_err("toy_run is missing");
    daemon.ctl(&["call", "toy", "run"]).expect_code(0);
}

#[test]
fn a_script_in_such_a_language_is_checked() {
    let (scratch, home) = toy("toy_start ether\n");
    let refused = home.refused(&["--check", &gen_file(scratch.path())]);
    refused.expect_code(1).expect_err("toy.words: toy_run is missing");
}

#[test]
fn a_runner_that_is_no_program_is_named_by_its_key() {
    let (scratch, _) = toy(SCRIPT);
    let config = "[runners.words]\nextension = \"words\"\ncommand = [\"/nowhere/runner\"]\n\
                  [cells]\nrestart_most = 0\n";
    let refused = Home::new().configured(config).refused(&["--check", &gen_file(scratch.path())]);
    refused.expect_code(1).expect_err("`/nowhere/runner` does not run");
    refused.expect_err("runners.words.command names the interpreter");
    let started = Home::new().configured(config).refused(&[&gen_file(scratch.path())]);
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
