//! genomctl on a terminal: its questions, interruption, layout and colours.

use genom_tests::{Daemon, component, path, program};
use serde_json::json;

fn stepped() -> Daemon {
    Daemon::start(&["--clock", "virtual", path(&component("demo").library)])
}

#[test]
fn inputs_are_asked_for_when_none_were_given() {
    let daemon = stepped();
    let question = "goal (double, Position to reach, m) [1.0]: ";
    let steps = json!([{"wait": question}, {"type": "0.25\n"}, {"wait": "activity 2"}]);
    daemon.on_terminal(80, &[], &steps, &["start", "demo", "goto"]).expect_code(0);
    daemon.ctl(&["step", "10s"]).expect_code(0);
    daemon.ctl(&["wait", "demo", "2"]).expect_code(0);
    assert_eq!(daemon.port("demo", "position")["value"]["position"], 0.25);
    // An empty answer takes the default; a service without inputs asks nothing.
    let steps = json!([{"wait": "[0.5]: "}, {"type": "\n"}, {"wait": "done"}]);
    daemon.on_terminal(80, &[], &steps, &["call", "demo", "set_speed"]).expect_code(0);
    let steps = json!([{"wait": "velocity = 0.5"}]);
    daemon.on_terminal(80, &[], &steps, &["call", "demo", "get_speed"]).expect_code(0);
    // The end of input sends no request.
    let steps = json!([{"wait": question}, {"type": "\u{4}"}, {"wait": "nothing was started"}]);
    daemon.on_terminal(80, &[], &steps, &["start", "demo", "goto"]).expect_code(2);
    let steps = json!([{"wait": "done"}]);
    daemon.on_terminal(80, &[], &steps, &["call", "demo", "set_speed", "{}"]).expect_code(0);
}

#[test]
fn a_wrong_answer_is_asked_for_again() {
    let daemon = stepped();
    let (question, refused) = ("velocity (double, ", "velocity: expected double");
    let wrong = [
        json!({"wait": question}),
        json!({"type": "fast\n"}),
        json!({"wait": refused}),
        json!({"wait": question}),
    ];
    let call = ["call", "demo", "set_speed"];
    let run = |more: serde_json::Value| {
        let steps = [&wrong[..], more.as_array().unwrap()].concat();
        daemon.on_terminal(80, &[], &steps.into(), &call)
    };
    run(json!([{"type": "0.25\n"}, {"wait": "done"}])).expect_code(0);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 0.25\n");
    // It gives up after three wrong answers, and at the end of input.
    let wrong = json!([{"type": "x\n"}, {"wait": refused}, {"type": "y\n"}, {"wait": refused}]);
    run(wrong).expect_code(1);
    run(json!([{"type": "\u{4}"}, {"wait": "no answer for velocity"}])).expect_code(2);
    daemon.ctl(&["call", "demo", "get_speed"]).expect_out("velocity = 0.25\n");
}

#[test]
fn ctrl_c_aborts_what_was_started_and_a_second_one_leaves_it() {
    let daemon = stepped();
    // It runs only after a step; an activity that is still waiting would end at once.
    let step = json!([program("genomctl"), "step", "100ms"]);
    let steps = json!([
        {"wait": "demo/goto (activity 2)"}, {"run": step}, {"type": "\u{3}"},
        {"wait": "Ctrl-C again leaves it alone"}, {"type": "\u{3}"},
        {"wait": "was told to stop, and still runs"}, {"wait": "genomctl wait demo 2"},
    ]);
    let arguments = ["start", "--wait", "demo", "goto", "goal=1"];
    daemon.on_terminal(100, &[], &steps, &arguments).expect_code(1);
    daemon.ctl(&["step", "10s"]).expect_code(0);
    // It ended far from its goal.
    daemon.ctl(&["wait", "demo", "2", "--timeout", "0"]).expect_code(0);
    assert!(daemon.port("demo", "position")["value"]["position"].as_f64().unwrap() < 0.5);

    // If time advances by itself, one Ctrl-C is enough: the axis brakes and the command ends.
    let daemon = Daemon::demo("local");
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.001"]).expect_code(0);
    let steps = json!([
        {"wait": "demo/goto (activity 2)"}, {"type": "\u{3}"},
        {"wait": "Ctrl-C again leaves it alone"},
    ]);
    let finished = daemon.on_terminal(100, &[], &steps, &arguments);
    assert_ne!(finished.code, Some(99), "{}", finished.out);
    let listed = daemon.json(&["activities", "demo"]);
    assert_ne!(listed["activities"][0]["status"], "running", "{listed}");
}

/// Lines without colour codes.
fn plain(text: &str) -> Vec<String> {
    let mut out = String::new();
    let mut pieces = text.split('\u{1b}');
    out.push_str(pieces.next().unwrap_or_default());
    for piece in pieces {
        out.push_str(piece.split_once('m').map_or("", |(_, rest)| rest));
    }
    out.lines().map(|line| line.trim_end_matches('\r').to_owned()).collect()
}

#[test]
fn tables_fit_the_terminal_and_colours_are_for_terminals_alone() {
    let daemon = stepped();
    let list = |columns, environment| {
        let finished = daemon.on_terminal(columns, environment, &json!([]), &["list"]);
        finished.expect_code(0);
        finished.out
    };
    for columns in [60, 80] {
        let out = list(columns, &[]);
        assert!(out.contains("\u{1b}[32mrunning\u{1b}[0m"), "{out:?}");
        let lines = plain(&out);
        assert!(lines.iter().all(|line| line.chars().count() <= columns), "{lines:#?}");
        assert!(lines.iter().any(|line| line.starts_with("demo") && line.ends_with('~')));
    }
    assert!(!list(80, &[("NO_COLOR", "1")]).contains('\u{1b}'));
    assert!(!list(80, &[("TERM", "dumb")]).contains('\u{1b}'));
    // Without a terminal nothing is cut or coloured.
    let finished = daemon.ctl(&["list"]);
    assert!(finished.out.contains(path(&component("demo").library)), "{}", finished.out);
    assert!(!finished.out.contains('\u{1b}'));
}

#[test]
fn the_live_table_shows_ports_and_gives_the_terminal_back() {
    let daemon = stepped();
    let steps =
        json!([{"wait": "demo/position"}, {"type": "p"}, {"wait": "paused"}, {"type": "q"}]);
    let finished = daemon.on_terminal(100, &[], &steps, &["top"]);
    finished.expect_code(0);
    // It switched to the alternate screen, and back.
    let (entered, left) = ("\u{1b}[?1049h", "\u{1b}[?1049l");
    assert!(finished.out.find(entered) < finished.out.rfind(left), "{:?}", finished.out);
    assert!(finished.out.contains(entered));
}

#[test]
fn events_are_told_as_they_happen() {
    let daemon = stepped();
    let mut following = Some(daemon.spawn(&["events", "-n", "1"]));
    // Fired repeatedly, so that one of them comes after the follower has begun to listen.
    let (sender, ended) = std::sync::mpsc::channel();
    std::thread::scope(|scope| {
        let following = following.take().unwrap();
        scope.spawn(move || sender.send(following.finish()).unwrap());
        let finished = loop {
            daemon.ctl(&["fire", "demo", "emergency"]).expect_code(0);
            if let Ok(finished) = ended.try_recv() {
                break finished;
            }
        };
        finished.expect_code(0).expect_out("event_fired component=demo name=emergency\n");
    });
}

#[test]
fn a_long_wait_is_seen_on_a_terminal_and_leaves_no_trace_elsewhere() {
    let daemon = stepped();
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    // The daemon holds this until the clock is stepped, which is after the text was seen.
    let step = json!([program("genomctl"), "step", "10s"]);
    let steps = json!([{"wait": "waiting for genomd, "}, {"run": step}, {"wait": "done"}]);
    let arguments = ["wait", "demo", "2", "--timeout", "50"];
    daemon.on_terminal(80, &[], &steps, &arguments).expect_code(0);
    let finished = daemon.ctl(&["wait", "demo", "2", "--timeout", "50"]);
    finished.expect_code(0).expect_out("done\n");
    assert_eq!(finished.err, "");
}

#[test]
fn one_key_of_the_live_table_stops_everything() {
    let daemon = stepped();
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    let steps = json!([
        {"wait": "s stops all activities"}, {"type": "s"}, {"wait": "activity told to stop"},
        {"type": "q"},
    ]);
    daemon.on_terminal(120, &[], &steps, &["top"]).expect_code(0);
    daemon.ctl(&["wait", "demo", "goto"]).expect_code(1).expect_err("::genom::interrupted");
}

#[test]
fn a_deployment_is_seen_to_wait_and_to_go_on() {
    let demo = component("demo");
    let paper = component("demo-2010");
    let daemon = Daemon::start(&["--backend", "shm", path(&demo.library)]);
    let file = daemon.home().path().join("robot.toml");
    let text = "[[connection]]\nin = \"demo/parameter\"\nout = \"later/position\"\n";
    std::fs::write(&file, text).unwrap();
    let genomctl = program("genomctl");
    let load = [path(&genomctl), "load", path(&paper.description), "--name", "later"];
    let step = "connect demo/parameter to later/position";
    let steps = json!([
        {"wait": format!("waiting: {step}, ")}, {"run": load}, {"wait": format!("done   {step}")},
    ]);
    daemon.on_terminal(80, &[], &steps, &["apply", path(&file)]).expect_code(0);
}
