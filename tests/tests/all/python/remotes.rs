//! Codels in Python call services of components in C, and are told their exceptions.

use std::fs;

use genom_tests::{Daemon, component, path};

const DESCRIPTION: &str = r#"interface axis {
  exception OUT_OF_RANGE { double value, lower, upper; string<64> what; };
  exception HALTED;
  activity goto(in double goal) { throw OUT_OF_RANGE, HALTED; };
};
component guide {
  lang "python";
  uses axis;
  ids { long sent; };
  task main {};
  activity send(in double goal, out string<64> what) {
    task main;
    async codel<start> guide_send(in goal, remote in goto, out what) yield ether;
    throw axis::HALTED, genom::no_such_service, genom::remote_io;
  };
};
"#;

const SCRIPT: &str = r#"
from genom.codel import Raised


def guide_send(goal: float, goto, what):
    try:
        goto(goal=goal)
    except Raised as refused:
        if goal < 10:
            raise
        # An exception of the demo, which the description does not know.
        what.value = f"{refused.event} {refused.what}"
    return "ether"
"#;

#[test]
fn a_service_of_a_component_in_c_is_called() {
    let scratch = tempfile::tempdir().unwrap();
    let file = scratch.path().join("guide.gen");
    fs::write(&file, DESCRIPTION).unwrap();
    fs::write(scratch.path().join("guide.py"), SCRIPT).unwrap();
    let demo = component("demo");
    let daemon = Daemon::start(&["--backend", "shm", path(&demo.library), path(&file)]);
    let send = |goal: &str| daemon.ctl(&["call", "guide", "send", goal]);
    send("goal=0.1").expect_code(1).expect_err("::genom::no_such_service");
    daemon.ctl(&["connect", "guide/goto", "demo/goto"]).expect_code(0);
    send("goal=0.05").expect_code(0).expect_out("what = \"\"\n");
    assert_eq!(daemon.port("demo", "position")["value"]["position"], 0.05);
    send("goal=11").expect_code(0).expect_out("what = \"::genom::unkex ::demo::OUT_OF_RANGE\"\n");
}
