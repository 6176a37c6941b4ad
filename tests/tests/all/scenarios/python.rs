//! Scenarios in Python: `genomctl test FILE.py` plays functions that step a daemon.

use std::fs;

use expect_test::expect;

use super::Place;

const PASSING: &str = r#"from genom.scenario import scenario
import genom

PATH = ["lib"]


@scenario
def a_motion_ends_at_its_goal(d):
    demo = d.load("demo")
    demo.set_speed(velocity=0.25)
    begun = d.now
    d.finish(demo.goto(0.5, ack=True))
    assert 2.0 <= d.now - begun <= 2.2
    assert demo.position.read()["position"] == 0.5


@scenario("what the axis cannot reach is refused with the bounds")
def refused(d):
    demo = d.load("demo")
    try:
        d.finish(demo.goto(99, ack=True))
    except genom.GenoMError as error:
        assert error.name == "::demo::OUT_OF_RANGE" and error.detail["upper"] == 10
    else:
        raise AssertionError("it is not refused")
    print("printed, and no part of the report")


@scenario(config="cells.toml")
def the_process_of_a_cell_comes_back(d):
    """A component comes back when the process of its cell is killed."""
    axis = d.component("axis")
    motion = axis.goto(1, ack=True)
    d.step(0.1)
    d.kill("arm")
    d.finish(d.component("axis").goto(0.1, ack=True))
    assert d.component("axis").position.read()["position"] == 0.1


@scenario
def faults(d):
    """Samples are lost, late and wrong until the connection is repaired"""

    def takes(goal, before=0.0, **fault):
        demo, mission = d.load("demo"), d.load("mission")
        demo.parameter.connect("mission/gain")
        mission.position.connect("demo/position")
        if before:
            d.step(before)
        if fault:
            d.fault(demo.parameter, **fault)
        there = moves(demo, goal)
        if fault:
            d.repair(demo.parameter)
        back = moves(demo, 0.0)
        # With the connection as it was, both ways are alike.
        assert back == {0.5: 1610, 0.05: 415}[goal], back
        d.unload("demo")
        d.unload("mission")
        return there

    def moves(demo, goal):
        begun = d.now
        d.finish(demo.goto(goal, ack=True))
        return round((d.now - begun) * 1000)

    # The same times as in tests/scenarios/links.toml, which has the reasons.
    assert takes(0.5, before=0.01, drop=True) == 1235
    assert takes(0.5, delay=0.5) == 1430
    assert takes(0.05) == 415
    assert takes(0.05, corrupt=0.0, samples=5) == 440
    assert takes(0.05, corrupt=0.0, every=20) == 615
    assert takes(0.05, corrupt=0.0, every=20, samples=2) == 485
"#;

const CELLS: &str = "path = [\"lib\"]\nclock = \"virtual\"\n\
    [[component]]\nlibrary = \"demo\"\nname = \"axis\"\ncell = \"arm\"\n";

#[test]
fn scenarios_in_python_pass_and_two_runs_give_the_same_bytes() {
    let place = Place::new();
    place.link("mission", "mission");
    fs::create_dir(place.path("tests")).unwrap();
    place.write("tests/motions.py", &PASSING.replace("[\"lib\"]", "[\"../lib\"]"));
    place.write("tests/cells.toml", &CELLS.replace("\"lib\"", "\"../lib\""));
    place.write("tests/other.py", "raise SystemExit(1)\n");
    let run = |report: &str| {
        let told = place.test(&["--junit", report]);
        told.expect_code(0).expect_err("printed, and no part of the report");
        (told.out, fs::read_to_string(place.path(report)).unwrap())
    };
    let (out, xml) = run("1.xml");
    assert_eq!((out.clone(), xml.clone()), run("2.xml"));
    assert!(out.ends_with("\n4 scenarios passed\n"), "{out}");
    assert!(xml.contains("name=\"A component comes back when the process of its cell is killed\""));
    assert!(xml.contains("tests.motions"), "{xml}");
    assert!(place.left().is_empty(), "{:?}", place.left());
    let shm = place.test(&["--backend", "shm", "--only", "faults"]);
    shm.expect_code(2).expect_err("no name of a scenario contains `faults`");
    let shm = place.test(&["--backend", "shm", "--only", "Samples are"]);
    shm.expect_code(0);
}

#[test]
fn a_scenario_in_python_that_does_not_hold_is_told_with_line_time_and_values() {
    let place = Place::new();
    place.write(
        "a.py",
        "from genom.scenario import scenario\n\
         PATH = [\"lib\"]\n\
         @scenario\n\
         def differs(d):\n\
         \x20   demo = d.load(\"demo\")\n\
         \x20   d.step(0.1)\n\
         \x20   assert demo.position.read()[\"position\"] == 0.5\n\
         @scenario\n\
         def takes_too_long(d):\n\
         \x20   demo = d.load(\"demo\")\n\
         \x20   d.finish(demo.goto(0.5, ack=True), within=0.01)\n\
         @scenario\n\
         def lacks_its_component(d):\n\
         \x20   d.load(\"dome\")\n\
         @scenario\n\
         def breaks(d):\n\
         \x20   1 / 0\n\
         @scenario\n\
         def ends_the_interpreter(d):\n\
         \x20   import os\n\
         \x20   os._exit(7)\n",
    );
    let came = place.test(&["a.py"]);
    came.expect_code(1).expect_err("error: 5 of 5 scenarios did not pass\n");
    came.expect_err("ZeroDivisionError");
    expect![[r#"
        a.py
          FAIL  differs (1 step, 0.100000000 s)
                a.py:7: assert demo.position.read()["position"] == 0.5
                  at        0.100000000 s
                  expected  demo.position.read()['position'] == 0.5
                  came      0.0 == 0.5
          FAIL  takes too long (0 steps, 0.010000000 s)
                a.py:11: d.finish(demo.goto(0.5, ack=True), within=0.01)
                  at        0.010000000 s
                  expected  that it is done
                  came      TimeoutError: <demo/goto 2: sent> still runs after 0.01 s of the clock
          FAIL  lacks its component (0 steps, 0.000000000 s)
                a.py:14: d.load("dome")
                  at        0.000000000 s
                  expected  that it is done
                  came      no_such_library: no library for dome: there is no dome.so nor libdome_codels.so nor libdome.so nor dome.py nor dome.lua, and none is installed; build the component, or name its directory or installation prefix with --path or GENOM_PATH (at /library)
          ERROR breaks (0 steps, 0.000000000 s)
                a.py:17: 1 / 0
                  at        0.000000000 s
                  expected  that it is done
                  came      ZeroDivisionError: division by zero
          ERROR ends the interpreter (0 steps, 0.000000000 s)
                a.py:18: the scenario
                  at        0.000000000 s
                  expected  that it ends
                  came      the interpreter ended before (exit status: 7)
        5 scenarios: 0 passed, 5 failed
    "#]]
    .assert_eq(&came.out);
    assert!(place.left().is_empty(), "{:?}", place.left());
}

#[test]
fn a_scenario_in_python_that_does_not_end_is_given_up_with_its_daemon() {
    let place = Place::new();
    place.write(
        "a.py",
        "from genom.scenario import scenario\n\
         @scenario\n\
         def waits(d):\n\
         \x20   import threading\n\
         \x20   open(\"pid\", \"w\").write(str(d.pid))\n\
         \x20   threading.Event().wait()\n",
    );
    let came = place.test(&["a.py", "--limit", "5"]);
    came.expect_code(1);
    let told = "came      it has not ended after 5 s of the machine's time";
    assert!(came.out.contains(told), "{}", came.out);
    let pid = fs::read_to_string(place.path("pid")).unwrap();
    assert!(!std::path::Path::new(&format!("/proc/{pid}")).exists(), "its daemon has ended");
    assert!(place.left().is_empty(), "{:?}", place.left());
}

#[test]
fn a_script_without_scenarios_or_with_mistakes_is_told_and_nothing_is_played() {
    let place = Place::new();
    place.write("none.py", "import genom.scenario\n");
    place.write("wrong.py", "from genom.scenario import scenario\ndef a(:\n");
    let none = place.test(&["none.py"]);
    none.expect_code(2).expect_err("none.py: no function is a scenario").expect_err("@scenario");
    place.test(&["wrong.py"]).expect_code(2).expect_err("SyntaxError");
    let lacks = place.test(&["none.py", "--python", "/nowhere/python"]);
    lacks.expect_code(2).expect_err("/nowhere/python: ").expect_err("--python");
}
