//! Heartbeats, orders and formulas of real components: told, shown by `genomctl monitor`, reacted
//! to, and refused where they are wrong; and what `genomctl verify` says of them.

use std::process::Command;

use genom_tests::{Daemon, Finished, Home, Running, component, path, program, request, until};
use serde_json::{Value, json};

use crate::control_plane::metrics::metrics;

fn demo(rules: &[&str]) -> String {
    let library = component("demo").library;
    let rules = rules.iter().map(|rule| format!("[[component.supervision]]\n{rule}\n"));
    format!("[[component]]\nlibrary = {library:?}\n{}", rules.collect::<String>())
}

fn genomctl(arguments: &[&str]) -> Finished {
    Running::start(Command::new(program("genomctl")).args(arguments)).finish()
}

#[track_caller]
fn rules(daemon: &Daemon) -> Vec<Value> {
    daemon.json(&["monitor", "demo"])["rules"].as_array().unwrap().clone()
}

#[test]
fn orders_and_formulas_of_the_demo_are_told_and_shown_with_what_did_not_hold() {
    let config = demo(&[
        "service = \"goto\"\nafter = \"set_speed\"",
        "formula = \"[] (goto -> once[0, 1000s] end(set_speed))\"\nreaction = \"log\"",
        "order = [\"still: goto -> moves\", \"moves: end(goto) -> still\"]",
        "port = \"position\"\nevery_ms = [0, 100000]\nwhile = \"goto\"",
        "activity = \"goto\"\nlongest_stop_ms = 100000",
        "task = \"main\"\nlongest_ms = 100000",
    ]);
    let daemon = Home::new().configured(&config).start(&[]);
    let mut events = daemon.events();
    assert!(daemon.ctl(&["monitor", "demo"]).out.contains("never"));
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    let told = events.wait_for(|e| e["event"] == "supervision_violated");
    assert_eq!((&told["index"], &told["kind"]), (&json!(0), &json!("logical")));
    assert_eq!(told["what"], "goto started, and `once end(set_speed)` did not hold");
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.5"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.02"]).expect_code(0);
    let rules = rules(&daemon);
    let count = |at: usize| rules[at]["violations"].as_u64().unwrap();
    assert_eq!([0, 1, 2, 3, 4, 5].map(count), [1, 1, 0, 0, 0, 0], "{rules:#?}");
    assert_eq!(rules[1]["kind"], "formula");
    let last = &rules[1]["last"];
    assert_eq!(last["what"], "goto started, and `once[0, 1000 s] end(set_speed)` did not hold");
    assert!(last["unix_ms"].as_u64().unwrap() > 1_600_000_000_000 && last["activity"] == 2);
    let shown = daemon.ctl(&["monitor", "demo"]).out;
    assert!(shown.contains("rule 1: goto started, and `once end(set_speed)`"), "{shown}");
    let metrics = metrics(&daemon);
    let line = "genom_supervision_violations_total{component=\"demo\",kind=\"formula\"";
    assert!(metrics.contains(line), "{metrics}");
    daemon.ctl(&["monitor", "dmo"]).expect_code(1).expect_err("did you mean");
}

#[test]
fn a_heartbeat_that_stops_is_told_with_its_time_and_interrupts_the_activity() {
    // The axis is moved each 5 ms.
    let config =
        demo(&["codel = \"demo_servo\"\nevery_ms = [50, 100000]\nreaction = \"interrupt\""]);
    let daemon = Home::new().configured(&config).start(&[]);
    let mut events = daemon.events();
    // Asked to stop, the axis brakes, and the activity ends long before its goal.
    daemon.ctl(&["start", "demo", "goto", "goal=9"]).expect_code(0);
    let told = events.wait_for(|e| e["event"] == "supervision_violated");
    assert_eq!((&told["kind"], &told["activity"]), (&json!("heartbeat"), &json!(2)));
    let rules = rules(&daemon);
    let last = &rules[0]["last"];
    assert_eq!(last["bound"], 50_000_000);
    assert!(last["value"].as_u64().unwrap() < 50_000_000, "{last}");
}

#[test]
fn a_component_that_breaks_a_rule_may_be_ended_in_order_and_signs_of_life_withheld() {
    let config = demo(&[
        "formula = \"not set_speed\"\nreaction = [\"withhold\", \"log\"]",
        "formula = \"not emergency\"\nreaction = \"kill\"",
    ]);
    let daemon = Home::new().configured(&config).start(&[]);
    let mut events = daemon.events();
    let none = daemon.ctl(&["monitor", "demo", "--clear"]).out;
    assert!(none.contains("no signs of life were withheld because of demo"), "{none}");
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.5"]).expect_code(0);
    events.wait_for(|e| e["event"] == "supervision_violated");
    let withheld = || daemon.json(&["monitor", "demo"])["withheld"].clone();
    assert!(withheld().as_str().unwrap().contains("formula supervision of demo"), "{}", withheld());
    assert!(daemon.ctl(&["monitor", "demo"]).out.contains("gets no sign of life"));
    let cleared = daemon.ctl(&["monitor", "demo", "--clear"]).out;
    assert!(cleared.contains("signs of life are given again"), "{cleared}");
    assert_eq!(withheld(), Value::Null);
    daemon.ctl(&["fire", "demo", "emergency"]).expect_code(0);
    events.wait_for(|e| e["event"] == "component_unloaded");
    until("it is gone", || daemon.json(&["list"])["components"].as_array().unwrap().is_empty());
}

#[test]
fn a_cell_has_signs_of_life_of_its_daemon_withheld() {
    let rules = demo(&["formula = \"not set_speed\"\nreaction = \"withhold\""]);
    let rules = rules.replacen("\n[[component.s", "\ncell = \"arm\"\n[[component.s", 1);
    let daemon = Home::new().configured(&rules).start(&[]);
    let mut events = daemon.events();
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.5"]).expect_code(0);
    events.wait_for(|e| e["event"] == "supervision_violated");
    let reply = request(&daemon.home().socket(), "GET", "/withheld", "");
    assert_eq!(reply.body["withheld"][0]["component"], "demo", "{reply:?}");
    let cleared = daemon.ctl(&["monitor", "demo", "--clear"]);
    assert!(cleared.expect_code(0).out.contains("given again"), "{cleared:?}");
    let reply = request(&daemon.home().socket(), "GET", "/withheld", "");
    assert_eq!(reply.body, json!({"withheld": []}));
}

#[test]
fn orders_and_formulas_that_fit_no_component_are_refused_with_file_line_and_column() {
    for (text, why) in [
        ("formula = \"gto -> once set_speed\"", "column 1: demo has no codel, service, out port"),
        ("formula = \"goto -> once end(set_sped)\"", "did you mean `set_speed`?"),
        ("formula = \"goto -> once parameter\"", "parameter is an in port"),
        ("formula = \"stop(set_speed)\"", "set_speed is no activity"),
        ("formula = \"true\"", "it names nothing that happens"),
        ("formula = \"goto -> once[1s, 1s] set_speed\"", "too many dates"),
        ("order = [\"a: goto -> b\", \"a: start(goto) -> a\"]", "leads two ways from state a"),
        ("order = [\"a: gto -> b\"]", "column 4: demo has no codel"),
        ("port = \"parameter\"\nevery_ms = [0, 5]", "parameter is an in port"),
        ("port = \"positon\"\nevery_ms = [0, 5]", "did you mean `position`?"),
        ("port = \"position\"\nevery_ms = [0, 5]\nwhile = \"set_speed\"", "has no activity"),
        ("service = \"goto\"\nafter = \"goto\"", "cannot come after itself"),
    ] {
        let home = Home::new().configured(&demo(&["stuck = true", text]));
        home.refused(&["--check"]).expect_code(1).expect_err(why);
        home.refused(&[])
            .expect_code(2)
            .expect_err(why)
            .expect_err(".toml:5: component.supervision");
    }
    let long = format!("formula = \"{}\"", "goto or ".repeat(1250));
    for (text, why) in [
        (long.as_str(), "10000 bytes, and 1000 are the most"),
        ("formula = \"goto ->\"", "supervision: `formula`, column 8"),
        ("order = [\"goto\"]", "step 1 of `order`, column 5"),
        ("port = \"position\"\nevery_ms = [5, 5]", "`every_ms` is [5, 5]"),
    ] {
        let home = Home::new().configured(&demo(&[text]));
        home.refused(&[]).expect_code(2).expect_err(why);
    }
    let many = vec!["stuck = true"; 1000];
    let home = Home::new().configured(&demo(&many));
    home.refused(&[]).expect_code(2).expect_err("1000 rules, and 32 are the most");
}

#[test]
fn verify_says_of_each_rule_whether_it_can_be_broken() {
    let home = Home::new().configured(&demo(&[
        "formula = \"end(goto) -> once start(goto)\"",
        "service = \"goto\"\nafter = \"set_speed\"",
        "formula = \"not goto\"",
        "formula = \"end(goto) -> once[0, 1s] start(goto)\"",
    ]));
    let (demo, config) = (component("demo").description, home.path().join("genomd.toml"));
    let args = ["verify", path(&demo), "--property", "loop", "--config", path(&config)];
    let found = genomctl(&args).out;
    for (number, verdict) in
        [(1, "cannot fire"), (2, "can fire: goto started"), (3, "always fires"), (4, "not decided")]
    {
        let line = found.lines().find(|line| line.contains(&format!("demo {number} ("))).unwrap();
        assert!(line.contains(verdict), "{line}");
    }
    assert!(found.contains("    client: requests goto"), "{found}");
    let json: Value =
        serde_json::from_str(&genomctl(&[&args[..], &["--json"]].concat()).out).unwrap();
    assert_eq!(json["components"][0]["rules"][0]["verdict"], "cannot_fire");
    // Mistakes have the file and the line.
    let wrong = Home::new().configured(&self::demo(&["formula = \"gto\""]));
    let file = wrong.path().join("genomd.toml");
    let args = ["verify", path(&demo), "--config", path(&file)];
    genomctl(&args).expect_code(2).expect_err("genomd.toml:3: ").expect_err("column 1");
}
