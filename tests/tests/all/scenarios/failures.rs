//! What is told of scenarios that do not pass: the step, when, what was expected and what came.

use std::fs;

use expect_test::{Expect, expect};

use super::{Place, steps};

/// Plays these steps with the demo; the last one does not hold.
#[track_caller]
fn check(all: &[&str], told: Expect) {
    check_with("[\"demo\"]", all, &[], told);
}

#[track_caller]
fn check_with(components: &str, all: &[&str], options: &[&str], told: Expect) {
    let place = Place::new();
    place.write("a.toml", &steps(components, all));
    let came = place.test(&[&["a.toml"], options].concat());
    came.expect_code(1).expect_err("error: 1 of 1 scenarios did not pass\n");
    told.assert_eq(&came.out);
    assert!(place.left().is_empty(), "{:?}", place.left());
}

const START: &str = "{ start = \"demo/goto\", inputs = { goal = 0.5 }, as = \"motion\" }";
const STEP: &str = "{ step = \"100ms\" }";

#[test]
fn a_value_that_differs() {
    let wanted = "{ expect = \"demo/position\", value = { position = 0.05, velocity = 1 }, tolerance = 0.1 }";
    check(
        &[START, STEP, wanted],
        expect![[r#"
        a.toml
          FAIL  a (2 steps, 0.100000000 s)
                a.toml:8: expect demo/position
                  at        0.100000000 s
                  expected  velocity = 1 within 0.1
                  came      velocity = 0.20000000000000004
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ expect = \"demo/parameter\", value = 1 }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: expect demo/parameter
                  at        0.000000000 s
                  expected  1
                  came      no value yet
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ expect = \"demo/position\", absent = true }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: expect demo/position
                  at        0.000000000 s
                  expected  no value
                  came      {"position":0.0,"velocity":0.0}
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ expect = \"demo/position\", samples = 7 }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: expect demo/position
                  at        0.000000000 s
                  expected  samples = 7
                  came      samples = 1
        1 scenario: 0 passed, 1 failed
    "#]],
    );
}

#[test]
fn another_end_of_a_service() {
    let far = "{ call = \"demo/goto\", inputs = { goal = 99 } }";
    check(
        &[far],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: call demo/goto
                  at        0.000000000 s
                  expected  done
                  came      ::demo::OUT_OF_RANGE {"value":99.0,"lower":-10.0,"upper":10.0,"what":"goal, m"}
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    let near = "{ call = \"demo/goto\", inputs = { goal = 0.1 }, throws = \"::demo::HALTED\" }";
    check(
        &[near],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.435000000 s)
                a.toml:6: call demo/goto
                  at        0.435000000 s
                  expected  ::demo::HALTED
                  came      done
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    let detail = "{ call = \"demo/goto\", inputs = { goal = 99 }, throws = \"::demo::OUT_OF_RANGE\", detail = { upper = 5, value = 99 } }";
    check(
        &[detail],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: call demo/goto
                  at        0.000000000 s
                  expected  upper = 5
                  came      upper = 10.0
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ call = \"demo/get_speed\", result = { velocity = 0.25 } }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: call demo/get_speed
                  at        0.000000000 s
                  expected  velocity = 0.25
                  came      velocity = 0.5
        1 scenario: 0 passed, 1 failed
    "#]],
    );
}

#[test]
fn an_activity_that_takes_longer_or_goes_another_way() {
    check(
        &[START, "{ wait = \"motion\", within = \"1s\" }"],
        expect![[r#"
        a.toml
          FAIL  a (1 step, 1.000000000 s)
                a.toml:7: wait motion
                  at        1.000000000 s
                  expected  an end within 1s
                  came      it still runs
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &[START, "{ wait = \"motion\", takes = { most = \"1s\" } }"],
        expect![[r#"
        a.toml
          FAIL  a (1 step, 1.235000000 s)
                a.toml:7: wait motion
                  at        1.235000000 s
                  expected  that it takes at most 1s
                  came      1235ms
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &[START, STEP, "{ expect = \"motion\", states = [\"main\", \"stop\"] }"],
        expect![[r#"
            a.toml
              FAIL  a (2 steps, 0.100000000 s)
                    a.toml:8: expect motion
                      at        0.100000000 s
                      expected  main > stop
                      came      main
            1 scenario: 0 passed, 1 failed
        "#]],
    );
    check(
        &[START, STEP, "{ expect = \"motion\", running = false }"],
        expect![[r#"
        a.toml
          FAIL  a (2 steps, 0.100000000 s)
                a.toml:8: expect motion
                  at        0.100000000 s
                  expected  that it has ended
                  came      that it runs
        1 scenario: 0 passed, 1 failed
    "#]],
    );
}

#[test]
fn a_component_that_is_otherwise() {
    let counts =
        "{ expect = \"demo\", codels = { demo_servo = 3, demo_brake = 0, demo_begin = 1 } }";
    check(
        &[START, STEP, counts],
        expect![[r#"
        a.toml
          FAIL  a (2 steps, 0.100000000 s)
                a.toml:8: expect demo
                  at        0.100000000 s
                  expected  demo_servo = 3
                  came      demo_servo = 20
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ expect = \"demo\", codels = [\"demo_init\", \"demo_halt\"] }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: expect demo
                  at        0.000000000 s
                  expected  demo_halt ran
                  came      it did not
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ expect = \"demo\", codels = { demo_sevro = 0 } }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: expect demo
                  at        0.000000000 s
                  expected  a codel `demo_sevro`
                  came      demo has none; did you mean `demo_servo`?
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ expect = \"demo\", missed = 3 }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: expect demo
                  at        0.000000000 s
                  expected  missed = 3
                  came      missed = 0
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ expect = \"demo\", state = \"down\" }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: expect demo
                  at        0.000000000 s
                  expected  down
                  came      running
        1 scenario: 0 passed, 1 failed
    "#]],
    );
}

#[test]
fn what_the_daemon_refuses() {
    check(
        &["{ call = \"demo/got\" }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: call demo/got
                  at        0.000000000 s
                  expected  that it is done
                  came      refused: demo has no service `got`
                  help      did you mean `goto`?
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ call = \"demo/goto\", inputs = { goal = \"far\" } }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: call demo/goto
                  at        0.000000000 s
                  expected  that it is done
                  came      refused: goal: expected double (a number, null, "inf" or "-inf"), found the string "far"
                  help      `genomctl info demo goto` shows the inputs
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ expect = \"dem/position\", absent = true }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: expect dem/position
                  at        0.000000000 s
                  expected  that it is done
                  came      refused: no component `dem`
                  help      did you mean `demo`?
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ publish = \"demo/position\", value = {} }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: publish demo/position
                  at        0.000000000 s
                  expected  that it is done
                  came      refused: demo/position is an out port: its codels write it, nobody else
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ wait = \"demo/goto\" }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: wait demo/goto
                  at        0.000000000 s
                  expected  that it is done
                  came      refused: no demo/goto runs, nor did lately
                  help      `genomctl info demo goto` tells what it is
        1 scenario: 0 passed, 1 failed
    "#]],
    );
}

#[test]
fn faults_of_what_is_not_there() {
    check(
        &["{ fault = \"demo/parameter\", drop = true }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: fault demo/parameter
                  at        0.000000000 s
                  expected  a connection of demo/parameter
                  came      it is not connected
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ repair = \"demo/parameter\" }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: repair demo/parameter
                  at        0.000000000 s
                  expected  a fault of demo/parameter
                  came      it has none
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check(
        &["{ kill = \"arm\" }"],
        expect![[r#"
        a.toml
          FAIL  a (0 steps, 0.000000000 s)
                a.toml:6: kill arm
                  at        0.000000000 s
                  expected  a cell `arm`
                  came      there is none
        1 scenario: 0 passed, 1 failed
    "#]],
    );
}

#[test]
fn a_daemon_that_does_not_begin() {
    check_with(
        "[\"nothing\"]",
        &[STEP],
        &[],
        expect![[r#"
        a.toml
          ERROR a (0 steps, 0.000000000 s)
                a.toml:3: begin
                  at        0.000000000 s
                  expected  a daemon with what the scenario names
                  came      its configuration:31: component.library: no library for nothing: there is no nothing.so nor libnothing_codels.so nor libnothing.so nor nothing.py nor nothing.lua, and none is installed; build the component, or name its directory or installation prefix with --path or GENOM_PATH
        1 scenario: 0 passed, 1 failed
    "#]],
    );
    check_with(
        "[\"demo\"]",
        &[STEP],
        &["--backend", "smoke"],
        expect![[r#"
        a.toml
          ERROR a (0 steps, 0.000000000 s)
                a.toml:3: begin
                  at        0.000000000 s
                  expected  a daemon with what the scenario names
                  came      its configuration:1: unknown backend `smoke`. This daemon knows: local, shm, zenoh, ros2
        1 scenario: 0 passed, 1 failed
    "#]],
    );
}

#[test]
fn a_step_that_does_not_end_is_given_up() {
    // The axis of the mission is moved by the thread that waits for it.
    let place = Place::new();
    place.link("mission", "mission");
    let text = steps(
        "[\"demo\", \"mission\"]",
        &[
            "{ connect = \"mission/goto\", to = \"demo/goto\" }",
            "{ start = \"mission/patrol\", inputs = { rounds = 1 } }",
            "{ step = \"1s\" }",
        ],
    );
    place.write("a.toml", &text);
    let came = place.test(&["a.toml", "--limit", "0.5"]);
    came.expect_code(1);
    expect![[r#"
        a.toml
          ERROR a (2 steps, 0.000000000 s)
                a.toml:8: step 1s
                  at        0.000000000 s
                  expected  that the step ends
                  came      it has not after 0.5 s of the machine's time
        1 scenario: 0 passed, 1 failed
    "#]]
    .assert_eq(&came.out);
}

#[test]
fn programs_read_failures_as_junit() {
    let place = Place::new();
    let one =
        |name: &str, steps: &str| format!("[[scenario]]\nname = \"{name}\"\nsteps = [{steps}]\n");
    let file = [
        "path = [\"lib\"]\ncomponents = [\"demo\"]\n".to_owned(),
        one("passes", STEP),
        one("<fails> & \\\"says\\\" so", "{ call = \"demo/goto\", inputs = { goal = 99 } }"),
        one("does not begin", STEP).replace("steps", "components = [\"nothing\"]\nsteps"),
    ];
    place.write("a.toml", &file.concat());
    place.test(&["a.toml", "--junit", "a.xml"]).expect_code(1);
    let text = fs::read_to_string(place.path("a.xml")).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let root = document.root_element();
    assert!(root.has_tag_name("testsuites"));
    let suite = root.children().find(|node| node.has_tag_name("testsuite")).unwrap();
    for node in [root, suite] {
        let counts = ["tests", "failures", "errors"].map(|key| node.attribute(key).unwrap());
        assert_eq!(counts, ["3", "1", "1"]);
    }
    let cases: Vec<_> = suite.children().filter(|node| node.has_tag_name("testcase")).collect();
    let names: Vec<_> = cases.iter().map(|case| case.attribute("name").unwrap()).collect();
    assert_eq!(names, ["passes", "<fails> & \"says\" so", "does not begin"]);
    assert_eq!(cases[0].attribute("time"), Some("0.100000000"));
    assert!(cases[0].first_element_child().is_none());
    let failure = cases[1].first_element_child().unwrap();
    assert!(failure.has_tag_name("failure"));
    let message = failure.attribute("message").unwrap();
    assert!(
        message.starts_with("expected done, came ::demo::OUT_OF_RANGE {\"value\":99.0"),
        "{message}"
    );
    assert!(failure.text().unwrap().starts_with("a.toml:8: call demo/goto, at 0.000000000 s\n"));
    assert!(cases[2].first_element_child().unwrap().has_tag_name("error"));
}
