//! What runners must not do: each has one precise error, and the daemon and its other components go on.

use std::fs;

use genom_tests::{Daemon, component, path};

use super::{DESCRIPTION, example, home, toy};

/// An answer that is right.
const RIGHT: &str = r#"{"functions": {"toy_start": FIRST, "toy_run": FUNCTION, "toy_other": FUNCTION}, "events": {"start": START, "end": END}, "number": 1}"#;

/// A daemon with the demo, where scripts in Words say what their runner does.
fn started() -> Daemon {
    home(&example("wrong.py")).start(&[path(&component("demo").library)])
}

/// The daemon has its other component, which works, and nothing of the one that was refused.
#[track_caller]
fn assert_goes_on(daemon: &Daemon) {
    daemon.ctl(&["call", "demo", "goto", "goal=0.001"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0"]).expect_code(0);
    let listed = daemon.json(&["list"]);
    let names: Vec<_> = listed["components"].as_array().unwrap().iter().collect();
    assert_eq!(names.len(), 1, "{listed}");
    assert_eq!(names[0]["name"], "demo");
}

#[test]
fn an_answer_that_is_none_is_refused_with_what_is_wrong() {
    let daemon = started();
    let (scratch, file) = toy(DESCRIPTION, "");
    let not = "toy.words: the answer of the runner is not as docs/runners.md says: ";
    let right = |from: &str, to: &str| format!("answer {}\nether", RIGHT.replace(from, to));
    for (script, told) in [
        (right("\"number\"", "number"), format!("{not}key must be a string at line 1")),
        (right("\"number\": 1", "\"number\": -1"), format!("{not}invalid value: integer `-1`")),
        (right(", \"number\": 1", ""), format!("{not}missing field `number`")),
        (
            right("\"toy_run\": FUNCTION", "\"toy_run\": 0"),
            format!("{not}the address of `toy_run` is 0"),
        ),
        (right("\"end\": END", "\"end\": 1"), format!("{not}no memory lies from `start` to `end`")),
        ("answer {\"errors\": []}\nether".to_owned(), format!("{not}`errors` is empty")),
        (right("\"toy_run\": FUNCTION, ", ""), "toy.words: codel `toy_run` (".to_owned()),
        ("silent".to_owned(), "toy.words: the runner gave no answer".to_owned()),
        (
            "large 4194305".to_owned(),
            "toy.words: the answer of the runner has more than 4 MiB".to_owned(),
        ),
    ] {
        fs::write(scratch.path().join("toy.words"), &script).unwrap();
        let refused = daemon.ctl(&["load", path(&file)]);
        refused.expect_code(1).expect_err(&told);
        assert_goes_on(&daemon);
    }
    fs::write(scratch.path().join("toy.words"), right("", "")).unwrap();
    daemon.ctl(&["load", path(&file)]).expect_code(0);
    daemon.ctl(&["call", "toy", "run"]).expect_code(0);
}

#[test]
fn a_runner_that_ends_while_it_loads_is_told_with_how() {
    let daemon = started();
    for (script, told) in [
        ("exit 7", "its process ended: exit status 7"),
        ("exit 0", "its process ended: exit status 0"),
        ("crash", "its process ended: signal 11 (SIGSEGV)"),
    ] {
        let (_scratch, file) = toy(DESCRIPTION, script);
        let refused = daemon.ctl(&["load", path(&file)]);
        refused.expect_code(1).expect_err(told).expect_err("the next load begins another one");
        assert!(!refused.err.contains("--restart"), "there is nothing to restart: {}", refused.err);
        assert_goes_on(&daemon);
    }
}

#[test]
fn an_event_that_was_not_told_ends_the_activity_and_nothing_else() {
    let daemon = started();
    let bad =
        |to: &str| format!("::genom::bad_transition {{\"from\":\"::toy::start\",\"to\":\"{to}\"}}");
    for (returned, told) in [
        // The text that stands there is none of the component.
        ("within", bad("oy::ether")),
        ("nowhere", bad("::toy::nowhere")),
        ("nothing", bad("genom_ok")),
        // Right or not, it stands where the runner did not say that events are.
        ("elsewhere", ", where no event is".to_owned()),
        ("wild", "toy_run returned 0x8, where no event is".to_owned()),
    ] {
        let (_scratch, file) = toy(DESCRIPTION, &format!("answer {RIGHT}\n{returned}"));
        daemon.ctl(&["load", path(&file)]).expect_code(0);
        let ended = daemon.ctl(&["call", "toy", "run"]);
        ended.expect_code(1).expect_err(&told);
        daemon.ctl(&["unload", "toy"]).expect_code(0);
        assert_goes_on(&daemon);
    }
}
