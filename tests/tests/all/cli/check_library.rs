//! `genomd --check` compares a library with its description; no daemon runs.

use std::fs;
use std::process::Command;

use genom_tests::{Finished, Home, Running, component, path, program, repository};

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

/// Output for a library whose constructor does this.
fn constructor(does: &str) -> Finished {
    let home = Home::new();
    let at = |name: &str| home.path().join(name);
    let source = format!(
        "#include <cstdlib>\n#include <stdexcept>\n\
         __attribute__((constructor)) static void made() {{ {does} }}\n"
    );
    fs::write(at("made.cc"), source).unwrap();
    let mut compiler = Command::new("c++");
    compiler.args(["-fPIC", "-shared", "-o"]).arg(at("made.so")).arg(at("made.cc"));
    Running::start(&mut compiler).finish().expect_code(0);
    let description = repository().join("components/demo/demo.gen");
    home.refused(&["--check", "--gen", path(&description), path(&at("made.so"))])
}

#[test]
fn a_constructor_that_ends_the_process_is_named() {
    let thrown = constructor("throw std::runtime_error(\"no licence\");");
    thrown.expect_code(1).expect_err("thrown by a constructor of ").expect_err("says: no licence");
    let left = constructor("exit(0);");
    left.expect_code(1).expect_err("exit called by a constructor of ").expect_err("made.so");
}
