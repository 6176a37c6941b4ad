//! A task that misses ticks is told before it runs, while it does and afterwards: with the same task,
//! and the same codel.

use std::path::Path;
use std::process::Command;

use genom_tests::{Daemon, Finished, Home, Running, fixture, path, program, until};
use serde_json::{Value, json};

use crate::control_plane::metrics::metrics;

/// `genomctl` in a directory, without a daemon.
fn alone(directory: &Path, arguments: &[&str]) -> Finished {
    let mut command = Command::new(program("genomctl"));
    command.current_dir(directory).args(arguments);
    Running::start(&mut command).finish()
}

/// Output of a verb with `--json` that has this exit status.
#[track_caller]
fn told(finished: &Finished, code: i32) -> Value {
    finished.expect_code(code);
    serde_json::from_str(&finished.out).unwrap_or_else(|error| panic!("{error}: {finished:?}"))
}

/// The task that may be late, and what would have to be shorter.
fn late(verified: &Value) -> (Value, Value) {
    let tasks = verified["components"][0]["tasks"].as_array().unwrap();
    let late: Vec<_> = tasks.iter().filter(|task| task["overrun"] != json!([])).collect();
    let [task] = late[..] else { panic!("{verified}") };
    (task["task"].clone(), task["needed"].clone())
}

/// A daemon that runs the component, supervised.
fn daemon(home: Home, gen_file: &str, settings: &str) -> Daemon {
    let library = Path::new(gen_file).with_extension("so");
    let config = format!(
        "[[component]]\nlibrary = {:?}\n{settings}\n\
         [[component.supervision]]\ntask = \"control\"\nmissed = 1\n\
         [[component.supervision]]\ncodel = \"overruns_decide\"\nlongest_ms = 20\n",
        path(&library)
    );
    home.configured(&config).start(&[])
}

/// Fails unless standard output contains this text.
#[track_caller]
fn says(finished: &Finished, text: &str) {
    assert!(finished.out.contains(text), "expected `{text}` in:\n{}", finished.out);
}

#[test]
fn an_overrun_is_told_before_while_and_after_it_happens_with_the_same_task_and_codel() {
    let home = Home::new();
    let gen_file = fixture("overruns", "overruns", home.path());
    // Before anything runs: the run, and what would have to be shorter.
    let arguments = ["--json", "verify", &gen_file, "--property", "overrun"];
    let (task, needed) = late(&told(&alone(home.path(), &arguments), 1));
    assert_eq!(task, "control");
    assert_eq!(needed, json!([{ "codel": "overruns_decide", "below_ns": 10_000_000 }]));
    // While it runs, its rules say so.
    let daemon = daemon(home, &gen_file, "");
    let mut events = daemon.events();
    let (mut missed, mut took) = (String::new(), String::new());
    while missed.is_empty() || took.is_empty() {
        let event = events.wait_for(|event| event["event"] == "supervision_violated");
        let place = if event["kind"] == "alive" { &mut missed } else { &mut took };
        *place = event["what"].as_str().unwrap().to_owned();
    }
    assert!(missed.starts_with("task control missed "), "{missed}");
    assert!(took.starts_with("codel overruns_decide of control "), "{took}");
    // Afterwards, what was measured: the rule may have been broken before the codel returned.
    until("the codel has returned", || {
        let stats = daemon.json(&["stats", "overruns"]);
        let mut all = stats["codels"].as_array().unwrap().iter();
        let decide = all.find(|codel| codel["name"] == "overruns_decide");
        decide.is_some_and(|codel| codel["durations"]["count"].as_u64().unwrap() > 0)
    });
    let stats = daemon.json(&["stats", "overruns"]);
    let task = &stats["tasks"][0];
    assert_eq!(task["name"], "control");
    assert!(task["overruns"].as_u64().unwrap() > 0, "{task}");
    let codel = |name: &str| {
        let mut all = stats["codels"].as_array().unwrap().iter();
        all.find(|codel| codel["name"] == name).unwrap().clone()
    };
    let (read, decide) = (codel("overruns_read"), codel("overruns_decide"));
    let ns = |codel: &Value, key: &str| codel["durations"][key].as_u64().unwrap();
    assert!(ns(&decide, "min_ns") >= 30_000_000, "{decide}");
    assert!(ns(&decide, "min_ns") <= ns(&decide, "mean_ns"), "{decide}");
    assert!(ns(&decide, "mean_ns") <= ns(&decide, "max_ns"), "{decide}");
    // What was yielded is counted, for each codel and event.
    let count = |codel: &Value, event: &str| {
        let mut all = codel["yielded"].as_array().unwrap().iter();
        all.find(|one| one["event"] == event).map_or(0, |one| one["count"].as_u64().unwrap())
    };
    assert!(count(&read, "plan").abs_diff(count(&decide, "pause::start")) <= 1, "{stats}");
    let all = count(&read, "plan") + count(&read, "pause::start");
    assert!(all.abs_diff(ns(&read, "count")) <= 1, "{read}");
    let shown = daemon.ctl(&["stats", "overruns", "--codels"]);
    says(&shown, "overruns_decide  control");
    says(&shown, "plan ");
    let metrics = metrics(&daemon);
    let yields = "genom_codel_yields_total{component=\"overruns\",owner=\"control\",\
                  codel=\"overruns_decide\",event=\"pause::start\"}";
    assert!(metrics.contains(yields), "{metrics}");
}

#[test]
fn what_runs_is_verified_with_its_configuration_and_its_description_as_it_was_loaded() {
    let home = Home::new();
    let gen_file = fixture("overruns", "overruns", home.path());
    let settings =
        "name = \"arm\"\ntasks.control = { period_ms = 200, priority = 7, cpus = [0] }\n";
    let daemon = daemon(home, &gen_file, settings);
    // What its file says now is no matter.
    std::fs::write(&gen_file, "component other { };").unwrap();
    let arguments = ["--json", "verify", "arm", "--property", "overrun"];
    let verified = told(&daemon.ctl(&arguments), 0);
    let component = &verified["components"][0];
    assert_eq!(
        (&component["instance"], &component["component"]),
        (&json!("arm"), &json!("overruns"))
    );
    assert_eq!(component["tasks"][0]["period_ns"], 200_000_000);
    assert_eq!(component["tasks"][0]["response_ns"], 90_000_000);
    let settings = &component["settings"][0];
    assert_eq!((&settings["priority"], &settings["cpus"]), (&json!(7), &json!([0])));
    let scheduled = told(&daemon.ctl(&["--json", "schedule", "arm"]), 0);
    assert_eq!(scheduled["components"][0]["tasks"][0]["response_ns"], 90_000_000);
    // Threads that are not real-time ones have no bound on processors that others use.
    let all = told(&daemon.ctl(&["--json", "schedule", "--all", "--processors", "2"]), 4);
    assert_eq!(all["tasks"][0]["component"], "arm");
    assert!(all["tasks"][0]["why"].as_str().unwrap().contains("not a real-time task"), "{all}");
    daemon.ctl(&["verify", "nobody"]).expect_code(1).expect_err("no component `nobody`");
    daemon.ctl(&["verify", "arm", "-I", "."]).expect_code(2).expect_err("it has been read already");
}

#[test]
fn measured_times_take_the_place_of_those_that_nobody_states() {
    let home = Home::new();
    let gen_file = fixture("overruns", "overruns", home.path());
    let text = std::fs::read_to_string(&gen_file).unwrap();
    let text = text.replace(" wcet 10 ms", "").replace(" wcet 80 ms", " wcet 5 ms");
    std::fs::write(&gen_file, text).unwrap();
    let daemon = daemon(home, &gen_file, "tasks.control = { period_ms = 1 }\n");
    let calls = |name: &str| {
        let stats = daemon.json(&["stats", "overruns"]);
        let mut all = stats["codels"].as_array().unwrap().iter();
        let found = all.find(|codel| codel["name"] == name).cloned();
        found.map_or(0, |codel| codel["durations"]["count"].as_u64().unwrap())
    };
    // It planned at least once, and ran too seldom for its times to be believed.
    until("it has planned", || calls("overruns_decide") > 0);
    let verify =
        || daemon.ctl(&["--json", "verify", "overruns", "--property", "overrun", "--measured"]);
    let codels =
        |verified: &Value| verified["components"][0]["measured"].as_array().unwrap().clone();
    until("it has run often", || calls("overruns_read") >= 1000);
    let verified = told(&verify(), 1);
    let codels = codels(&verified);
    assert_eq!(
        (&codels[0]["codel"], &codels[0]["taken"]),
        (&json!("overruns_read"), &json!("measured"))
    );
    // It took 30 ms, and 5 are stated: a finding.
    let decide = &codels[1];
    assert_eq!(
        (&decide["codel"], &decide["above_wcet"]),
        (&json!("overruns_decide"), &json!(true))
    );
    let people = daemon.ctl(&["verify", "overruns", "--property", "overrun", "--measured"]);
    says(people.expect_code(1), "measured VIOLATED\n  overruns_decide took ");
    let (task, _) = late(&verified);
    assert_eq!(task, "control");
}

#[test]
fn a_run_to_an_overrun_is_written_as_a_recording_and_as_a_scenario_that_shows_it() {
    let home = Home::new();
    let gen_file = fixture("overruns", "overruns", home.path());
    std::fs::remove_file(Path::new(&gen_file).with_extension("so")).unwrap();
    let traces = ["--trace", "run.toml", "--trace", "run.mcap"];
    let verify = ["verify", "overruns.gen", "--property", "overrun"];
    alone(home.path(), &[&verify[..], &traces].concat()).expect_code(1);
    let played = alone(home.path(), &["test", "run.toml"]);
    says(played.expect_code(0), "overruns: control is at work at its tick at ");
    // The runtime does not do what the script does not say.
    let text = std::fs::read_to_string(home.path().join("run.toml")).unwrap();
    let other = text.replace("returns = \"overruns_read\"", "returns = \"overruns_decide\"");
    assert_ne!(text, other);
    std::fs::write(home.path().join("other.toml"), other).unwrap();
    let refused = alone(home.path(), &["test", "other.toml"]);
    says(refused.expect_code(1), "overruns_decide is not being executed: control executes");
    // The recording is one of the public format, with the channels of the recorder.
    let recorded = std::fs::read(home.path().join("run.mcap")).unwrap();
    let messages: Vec<_> =
        mcap::MessageStream::new(&recorded).unwrap().map(Result::unwrap).collect();
    let of = |topic: &str| -> Vec<(u64, Value)> {
        let all = messages.iter().filter(|message| message.channel.topic == topic);
        all.map(|one| (one.log_time, serde_json::from_slice(&one.data).unwrap())).collect()
    };
    let (date, overrun) = of("/genom/changes").pop().unwrap();
    assert_eq!((&overrun["event"], &overrun["task"]), (&json!("overrun"), &json!("control")));
    let codels = of("/genom/codels");
    let begins = |codel: &Value| codel["codel"] == "overruns_decide" && codel["event"] == "begins";
    let (begun, _) = codels.iter().rfind(|(_, codel)| begins(codel)).unwrap();
    assert!(*begun < date, "{codels:?}");
}
