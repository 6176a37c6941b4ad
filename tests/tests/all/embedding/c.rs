//! A program in C, and one in C++.

use std::path::{Path, PathBuf};
use std::process::Command;

use genom_tests::{Finished, Running, component, path, program, repository};
use tempfile::TempDir;

/// Compiles `tests/fixtures/embedding/loop.c` as its author would, with these options to link it.
#[track_caller]
fn built(compiler: &[&str], link: &[&str]) -> (TempDir, PathBuf) {
    let scratch = tempfile::tempdir().unwrap();
    let header = Running::start(
        Command::new(program("genomctl")).args(["header", path(&component("demo").description)]),
    )
    .finish();
    header.expect_code(0);
    std::fs::write(scratch.path().join("demo_c_types.h"), &header.out).unwrap();
    let made = scratch.path().join("loop");
    let mut command = Command::new(compiler[0]);
    command.args(&compiler[1..]).args(["-Wall", "-Wextra", "-Werror", "-g", "-I"]);
    command.arg(repository().join("clients/c/include")).arg("-I").arg(scratch.path());
    command.arg("-I").arg(repository().join("plugin-api/include"));
    command.arg(repository().join("tests/fixtures/embedding/loop.c"));
    command.args(["-x", "none"]).args(link).arg("-o").arg(&made);
    Running::start(&mut command).finish().expect_code(0);
    (scratch, made)
}

/// Where the libraries are: beside the programs.
fn libraries() -> PathBuf {
    program("genomd").parent().unwrap().to_owned()
}

fn run(made: &Path, options: &[&str]) -> Finished {
    let mut command = Command::new(made);
    command.arg(component("demo").library).args(options).env("GENOMD", program("genomd"));
    command.env("GENOMCTL", program("genomctl"));
    let finished = Running::start(&mut command).finish();
    finished.expect_code(0);
    finished
}

#[test]
fn a_program_in_c_steps_a_component_and_is_told_what_is_wrong() {
    let library = libraries().join("libgenomd_client.a");
    let link = [path(&library), "-lpthread", "-ldl", "-lm"];
    let (_scratch, made) = built(&["cc", "-std=c99", "-x", "c"], &link);
    let (first, second) = (run(&made, &[]), run(&made, &[]));
    assert_eq!(first.out, second.out, "equal steps with equal values");
    let in_a_cell = run(&made, &["--cell", "arm"]);
    assert_eq!(in_a_cell.out, first.out, "wherever the component runs");
    let rows: Vec<&str> = first.out.lines().collect();
    assert_eq!(rows.last(), Some(&"arrived"), "{}", first.out);
    assert!(rows.len() > 100, "{}", first.out);
}

#[test]
fn a_program_in_cpp_does_the_same_with_the_shared_library() {
    let at = libraries();
    let (search, found) = (format!("-L{}", path(&at)), format!("-Wl,-rpath,{}", path(&at)));
    let link = [&search, &found, "-lgenomd_client"];
    let (_scratch, made) = built(&["c++", "-std=c++11", "-x", "c++"], &link);
    assert!(run(&made, &[]).out.ends_with("arrived\n"));
}
