//! A library is checked against its description without a daemon.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests fail them")]

use std::fs;
use std::process::Command;

use genom_tests::{Home, Running, component, path, program, repository};

#[test]
fn a_library_that_fits_is_told_with_its_digest_and_nothing_is_started() {
    let home = Home::new();
    let library = component("demo").library;
    let fits = home.refused(&["--check", path(&library)]);
    fits.expect_code(0);
    assert!(fits.out.contains("component demo, digest "), "{}", fits.out);
    assert!(!home.socket().exists());
}

#[test]
fn genomctl_hands_libraries_to_the_genomd_beside_it() {
    let library = component("demo").library;
    let mut command = Command::new(program("genomctl"));
    command.env_clear().args(["check", path(&library)]);
    let fits = Running::start(&mut command).finish();
    fits.expect_code(0);
    assert!(fits.out.contains("component demo, digest "), "{}", fits.out);
}

#[test]
fn a_library_that_lacks_a_codel_is_refused_with_the_line_of_the_description() {
    let home = Home::new();
    let library = component("demo").library;
    let text = fs::read_to_string(repository().join("components/demo/demo.gen")).unwrap();
    let other = text.replace("demo_servo(", "demo_dance(");
    let line = other.lines().position(|line| line.contains("demo_dance(")).unwrap() + 1;
    fs::write(home.path().join("other.gen"), other).unwrap();
    let refused = home.refused(&["--check", "--gen", "other.gen", path(&library)]);
    refused.expect_code(1).expect_err("demo_dance").expect_err(&format!("other.gen:{line}"));
    home.refused(&["--check"]).expect_code(2).expect_err("--check goes with the libraries");
}
