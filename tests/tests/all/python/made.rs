//! `genomctl new --lang python`, and the stub that editors know its types by.

use std::fs;
use std::process::Command;

use genom_components::python;
use genom_tests::{Finished, Running, program, repository};

/// Runs a program of ours where its interpreter finds the package.
fn run(words: &[&str], directory: &std::path::Path) -> Finished {
    let mut command = Command::new(program(words[0]));
    command.args(&words[1..]).current_dir(directory);
    command.env("PYTHONPATH", repository().join("clients/python/src"));
    Running::start(&mut command).finish()
}

#[test]
fn a_new_component_runs_and_passes_its_test() {
    let scratch = tempfile::tempdir().unwrap();
    let made = run(&["genomctl", "new", "arm", "--lang", "python"], scratch.path());
    made.expect_code(0);
    assert!(made.out.ends_with("created arm/arm.py\nnext: genomd arm/arm.py\n"), "{}", made.out);
    let checked = run(&["genomd", "--check", "arm/arm.gen"], scratch.path());
    checked.expect_code(0);
    assert!(checked.out.starts_with("arm/arm.py fits arm/arm.gen: "), "{}", checked.out);
    let tested = run(&["genomctl", "test", "arm/tests"], scratch.path());
    assert!(tested.out.ends_with("2 scenarios passed\n"), "{}\n{}", tested.out, tested.err);
    let refused =
        run(&["genomctl", "new", "leg", "--lang", "python", "--with", "cmake"], scratch.path());
    refused.expect_code(2).expect_err("nothing builds codels in Python");
}

/// A description with a type of each kind, in scopes.
const KINDS: &str = r#"module geometry {
  struct point { double x; double y; };
  enum axis { X, Y };
};
const unsigned long JOINTS = 6;
component all {
  lang "python";
  enum speed { SLOW, FAST };
  union choice switch (speed) { case SLOW: long steps; case FAST: geometry::point at; };
  typedef double gains[JOINTS];
  exception TOO_FAR { double limit; string<16> from; };
  exception MOVING;
  ids {
    geometry::point at; geometry::axis along; gains all; speed fast; choice chosen;
    sequence<geometry::point> path; sequence<long, 4> few; optional<double> maybe; string name;
    geometry::point corners[4]; boolean halted; octet byte; long while;
  };
  function go() { codel all_go(inout ::ids); throw TOO_FAR, MOVING; };
};
"#;

/// Codels that use all of them.
const SCRIPT: &str = r#"
from all_types import FAST, JOINTS, MOVING, TOO_FAR, geometry, ids, speed


def all_go(ids: ids) -> None:
    ids.at = geometry.point(x=1.0, y=ids.at.x + 1)
    ids.along = geometry.axis.Y
    ids.all[JOINTS - 1] = 2.5
    ids.fast = FAST
    ids.chosen.d = speed.FAST
    ids.chosen.at = ids.at
    ids.path.append(geometry.point(x=3.0))
    ids.path[0].y = ids.path[-1].x
    ids.few.resize(4)
    ids.maybe = None if ids.maybe is not None else 1.5
    ids.name = ids.name + "!"
    ids.corners[3].x = 4.0
    ids.while_ = 7
    if ids.halted:
        raise MOVING
    if ids.byte > 2:
        raise TOO_FAR(limit=2.0, from_="here")
    ids.byte += 1
"#;

#[test]
fn a_stub_knows_all_kinds_of_types_as_they_are_when_codels_run() {
    let scratch = tempfile::tempdir().unwrap();
    fs::write(scratch.path().join("all.gen"), KINDS).unwrap();
    fs::write(scratch.path().join("all.py"), SCRIPT).unwrap();
    let stub = run(&["genomctl", "header", "--lang", "python", "all.gen"], scratch.path());
    stub.expect_code(0);
    fs::write(scratch.path().join("all_types.pyi"), &stub.out).unwrap();
    let python = python::environment(&["mypy==2.4.1"]).unwrap_or_else(|error| panic!("{error}"));
    let check = |script: &str| {
        let mut command = Command::new(&python);
        command.current_dir(scratch.path());
        command.env("MYPYPATH", repository().join("clients/python/src"));
        command.args([
            "-m",
            "mypy",
            "--strict",
            "--follow-imports",
            "silent",
            "--cache-dir",
            "cache",
            script,
        ]);
        Running::start(&mut command).finish()
    };
    let checked = check("all.py");
    assert_eq!(checked.code, Some(0), "{}\n{}", checked.out, stub.out);
    let wrong = SCRIPT.replace("ids.at.x + 1", "ids.at.z + 1");
    // In a file of its own: of one that keeps its size within a second, mypy's cache says "no issues".
    fs::write(scratch.path().join("wrong.py"), wrong).unwrap();
    let refused = check("wrong.py").out;
    assert!(refused.contains("\"point\" has no attribute \"z\""), "{refused}");

    // And so it is.
    let daemon = genom_tests::Daemon::start(&[genom_tests::path(&scratch.path().join("all.gen"))]);
    let go = || daemon.ctl(&["call", "all", "go"]);
    (0..3).for_each(|_| _ = go().expect_code(0).expect_out("done\n"));
    go().expect_code(1).expect_err("::all::TOO_FAR {\"limit\":2.0,\"from\":\"here\"}");
}
