//! Deployment files: started from, applied, dumped, refused, kept in force.

use std::fmt::Write as _;
use std::sync::Arc;

use genom_tests::{Daemon, Home, Memory, component, path, until_answer};
use serde_json::Value;

/// The paper's component and a demo that reads it, on one daemon.
fn pair() -> String {
    let (paper, demo) = (component("demo-2010"), component("demo"));
    format!(
        r#"
[[component]]
library = {:?}
name = "reader"
after = ["paper"]
attributes = {{ set_speed = {{ velocity = 0.75 }} }}
tasks = {{ main = {{ period_ms = 4.0 }} }}

[[component]]
library = {:?}
name = "paper"

[[connection]]
in = "reader/parameter"
out = "paper/position"
policy = "ring:4"

[[call]]
component = "paper"
service = "goto"
inputs = {{ position = 0.25 }}
"#,
        demo.library, paper.description
    )
}

fn write(daemon: &Daemon, text: &str) -> String {
    let file = daemon.home().path().join("robot.toml");
    std::fs::write(&file, text).unwrap();
    path(&file).to_owned()
}

#[test]
fn a_file_is_applied_once_and_then_there_is_nothing_to_do() {
    let daemon = Daemon::start(&["--backend", "shm"]);
    let file = write(&daemon, &pair());
    let planned = daemon.json(&["apply", "--dry-run", &file]);
    assert_eq!(
        (&planned["applied"], planned["steps"].as_array().unwrap().len()),
        (&false.into(), 4)
    );
    assert!(planned["steps"][0].as_str().unwrap().starts_with("load paper from "), "{planned}");
    assert_eq!(daemon.json(&["list"])["components"], Value::Array(Vec::new()));

    let applied = daemon.ctl(&["apply", &file]);
    applied.expect_code(0);
    assert!(
        applied.out.ends_with("done   call paper/goto {\"position\":0.25}\n"),
        "{}",
        applied.out
    );
    daemon.ctl(&["call", "reader", "get_speed"]).expect_out("velocity = 0.75\n");
    daemon.ctl(&["call", "reader", "goto", "goal=0.01"]).expect_code(0);
    assert_eq!(daemon.port("reader", "parameter")["value"], 0.25);
    assert_eq!(daemon.json(&["stats", "reader"])["tasks"][0]["period_ns"], 4_000_000);

    let again = daemon.ctl(&["apply", &file]);
    again.expect_code(0).expect_out("nothing to do: everything is as the file says\n");
    // Only what differs is changed.
    daemon.ctl(&["call", "reader", "set_speed", "velocity=0.5"]).expect_code(0);
    daemon.ctl(&["disconnect", "reader/parameter"]).expect_code(0);
    let steps = daemon.json(&["apply", &file])["steps"].clone();
    let wanted = serde_json::json!([
        "set reader/set_speed {\"velocity\":0.75}",
        "connect reader/parameter to paper/position",
    ]);
    assert_eq!(steps, wanted);
}

#[test]
fn a_dump_applied_on_a_fresh_daemon_gives_the_same() {
    let daemon = Daemon::start(&["--backend", "shm"]);
    daemon.ctl(&["apply", &write(&daemon, &pair())]).expect_code(0);
    daemon.ctl(&["backend", "paper/position", "shm+zenoh"]).expect_code(0);
    let dumped = daemon.ctl(&["dump"]);
    dumped.expect_code(0);
    assert!(dumped.out.contains("position = \"shm+zenoh\""), "{}", dumped.out);

    let fresh = Daemon::start(&["--backend", "local"]);
    fresh.ctl(&["apply", &write(&fresh, &dumped.out)]).expect_code(0);
    // Without the options of its own middlewares.
    let runs = |dump: &str| dump[dump.find("[[component]]").unwrap()..].to_owned();
    assert_eq!(runs(&fresh.ctl(&["dump"]).out), runs(&dumped.out));
    fresh.ctl(&["call", "reader", "get_speed"]).expect_out("velocity = 0.75\n");
}

#[test]
fn a_refused_step_takes_back_all_that_were_taken() {
    let daemon = Daemon::start(&["--backend", "shm"]);
    let wrong = pair()
        + "[[activity]]\ncomponent = \"reader\"\nservice = \"goto\"\ninputs = { goal = 99.0 }\n";
    let refused = daemon.ctl(&["apply", &write(&daemon, &wrong)]);
    refused.expect_code(1).expect_err("reader/goto ended with ::demo::OUT_OF_RANGE");
    assert_eq!(daemon.json(&["list"])["components"], Value::Array(Vec::new()));

    // The other side of a connection never appears.
    let waits = pair().replace("\"paper/position\"", "\"nobody/position\"");
    let refused = daemon.ctl(&["apply", "--timeout", "0.1", &write(&daemon, &waits)]);
    refused.expect_code(1).expect_err("connect reader/parameter to nobody/position: nothing after");
    refused.expect_err("everything is as it was before");
    assert_eq!(daemon.json(&["list"])["components"], Value::Array(Vec::new()));
}

#[test]
fn a_mistake_names_file_line_and_key_and_changes_nothing() {
    let daemon = Daemon::start(&["--backend", "shm"]);
    for (from, to, told) in [
        ("policy = ", "polcy = ", "robot.toml:16: unknown field `polcy`"),
        ("policy = ", "polcy = ", "did you mean `policy`?"),
        ("\"ring:4\"", "\"ring\"", "robot.toml:16: "),
        ("\"paper/position\"", "\"smh:paper/position\"", "robot.toml:15: unknown backend `smh`"),
        ("policy = \"ring:4\"", "backend = \"smh\"", "robot.toml:16: unknown backend `smh`"),
        ("component = \"paper\"", "component = \"papr\"", "did you mean `paper`?"),
        ("after = [\"paper\"]", "after = [\"papre\"]", "did you mean `paper`?"),
        ("set_speed", "set_sped", "reader has no attribute `set_sped`; did you mean `set_speed`?"),
        ("{ main = {", "{ man = {", "reader has no task `man`; did you mean `main`?"),
        ("period_ms = 4.0", "period_ms = -4.0", "no period"),
    ] {
        let text = pair().replacen(from, to, 1);
        assert_ne!(text, pair(), "{from}");
        daemon.ctl(&["apply", &write(&daemon, &text)]).expect_code(1).expect_err(told);
    }
    assert_eq!(daemon.json(&["list"])["components"], Value::Array(Vec::new()));
    daemon.ctl(&["apply", "nothing.toml"]).expect_code(2).expect_err("nothing.toml");
}

/// Mistakes that only show when the file is applied, because they concern the content of
/// components.
#[test]
fn a_mistake_about_a_component_names_file_line_and_key_and_takes_all_back() {
    let daemon = Daemon::start(&["--backend", "shm"]);
    let activity = "[[activity]]\ncomponent = \"reader\"\nservice = \"goto\"\n\
                    inputs = { goal = 0.5 }\n";
    let right = pair() + activity;
    for (from, to, told) in [
        ("in = \"reader/parameter\"", "in = \"reader/parametr\"", "robot.toml:14: connection.in: "),
        ("in = \"reader/parameter\"", "in = \"reader/position\"", "reader/position is an out port"),
        ("\"paper/position\"", "\"paper/positoin\"", "robot.toml:15: connection.out: "),
        ("\"paper/position\"", "\"reader/position\"", "robot.toml:15: connection.out: "),
        ("velocity = 0.75", "velocity = \"x\"", ":6: component.attributes.set_speed.velocity: "),
        ("velocity = 0.75", "speed = 0.75", ":6: component.attributes.set_speed: "),
        ("velocity = 0.75", "velocity = 75.0", ":6: component.attributes.set_speed: "),
        ("set_speed", "set_sped", "robot.toml:6: component.attributes.set_sped: "),
        ("{ main = {", "{ man = {", "robot.toml:7: component.tasks.man: "),
        ("inputs = { position", "inputs = { positon", "robot.toml:21: call.inputs: "),
        ("position = 0.25", "position = \"far\"", "robot.toml:21: call.inputs.position: "),
        (
            "service = \"goto\"\ninputs = { pos",
            "service = \"go\"\ninputs = { pos",
            ":20: call.service: ",
        ),
        ("goal = 0.5", "goal = 99.0", "robot.toml:22: activity: "),
        ("component = \"paper\"", "component = \"papr\"", "robot.toml:19: call.component: "),
        ("after = [\"paper\"]", "after = [\"papre\"]", "robot.toml:5: component.after: "),
    ] {
        let text = right.replacen(from, to, 1);
        assert_ne!(text, right, "{from}");
        daemon.ctl(&["apply", &write(&daemon, &text)]).expect_code(1).expect_err(told);
        // The state is as before: nothing runs, and every name and address is free.
        assert_eq!(daemon.json(&["list"])["components"], Value::Array(Vec::new()), "{to}");
    }
    daemon.ctl(&["apply", &write(&daemon, &right)]).expect_code(0);
    // The same at the start of a daemon.
    let home = Home::new().configured(&right.replacen("velocity = 0.75", "velocity = 75.0", 1));
    let refused = home.refused(&["--backend", "shm"]);
    refused.expect_code(1).expect_err("genomd.toml:6: component.attributes.set_speed: ");
}

#[test]
fn an_apply_tells_what_it_waits_for() {
    let daemon = Daemon::start(&["--backend", "shm"]);
    let waits = pair().replace("\"paper/position\"", "\"later/position\"");
    let applying = daemon.spawn(&["apply", "--timeout", "60", &write(&daemon, &waits)]);
    let line = applying.error_line_where(|line| line.contains("waiting"));
    assert_eq!(line.as_deref(), Some("waiting: connect reader/parameter to later/position"));
    // Its writer starts in another daemon on the same middleware.
    let paper = component("demo-2010");
    let other = Home::with(daemon.home().memory());
    let _writer = other.start(&["--backend", "shm", "--name", "later", path(&paper.description)]);
    applying.finish().expect_code(0);
    assert_eq!(daemon.port("reader", "parameter")["connected"], "later/position");
}

/// Seven components on two middlewares in two daemons, six connections, a call, an activity.
fn robot() -> String {
    let (paper, demo) = (component("demo-2010"), component("demo"));
    let mut text = format!(
        "backend = \"shm\"\n[[component]]\ndaemon = \"base\"\nname = \"paper\"\n\
         library = {:?}\nports = {{ position = [\"shm\", \"zenoh\"] }}\n",
        paper.description
    );
    for number in 0..6 {
        let daemon = if number < 3 { "base" } else { "arm" };
        let backend = if number % 2 == 0 { "shm" } else { "zenoh" };
        write!(
            text,
            "[[component]]\ndaemon = \"{daemon}\"\nname = \"reader{number}\"\n\
             library = {:?}\nbackend = \"{backend}\"\n\
             [[connection]]\nin = \"reader{number}/parameter\"\nout = \"paper/position\"\n",
            demo.library
        )
        .unwrap();
    }
    text + "[[call]]\ncomponent = \"paper\"\nservice = \"goto\"\ninputs = { position = 0.25 }\n\
            [[activity]]\ncomponent = \"reader3\"\nservice = \"goto\"\ninputs = { goal = 0.01 }\n"
}

fn deployed(daemon: &Daemon) {
    let line = daemon.process().error_line_where(|line| line.contains("deployed:"));
    assert!(line.is_some(), "the daemon ended");
}

#[test]
fn two_daemons_come_up_from_one_file_and_a_killed_one_is_wired_again() {
    let memory = Arc::new(Memory::new());
    let start = |name| Home::with(&memory).configured(&robot()).start(&["--daemon", name]);
    // The reader is started first, and waits for the writer.
    let arm = start("arm");
    let base = start("base");
    deployed(&arm);
    deployed(&base);
    for daemon in [&arm, &base] {
        let connections = daemon.json(&["connections"])["connections"].clone();
        let mut backends: Vec<&str> = connections
            .as_array()
            .unwrap()
            .iter()
            .map(|connection| connection["backend"].as_str().unwrap())
            .collect();
        backends.sort_unstable();
        assert_eq!(backends.len(), 3, "{connections}");
        assert!(backends.contains(&"shm") && backends.contains(&"zenoh"), "{connections}");
    }
    let reads = |daemon: &Daemon, reader: &str| {
        daemon.ctl(&["call", reader, "goto", "goal=0.001"]).expect_code(0);
        daemon.ctl(&["call", reader, "goto", "goal=0"]).expect_code(0);
        daemon.port(reader, "parameter")["value"].clone()
    };
    for reader in ["reader3", "reader4", "reader5"] {
        until_answer(&Value::from(0.25), || reads(&arm, reader));
    }

    // The writer's daemon is killed and started again: samples arrive without any command.
    let (_, home) = base.stop("KILL");
    let base = home.start(&["--daemon", "base"]);
    deployed(&base);
    base.ctl(&["call", "paper", "goto", "position=0.75"]).expect_code(0);
    for reader in ["reader3", "reader4", "reader5"] {
        until_answer(&Value::from(0.75), || reads(&arm, reader));
    }

    // The same when a reader is unloaded and loaded again.
    let demo = component("demo");
    arm.ctl(&["unload", "reader4"]).expect_code(0);
    arm.ctl(&["load", path(&demo.library), "--name", "reader4", "--backend", "shm"]).expect_code(0);
    until_answer(&Value::from("paper/position"), || {
        arm.port("reader4", "parameter")["connected"].clone()
    });
    until_answer(&Value::from(0.75), || reads(&arm, "reader4"));
    // A connection that was ended by hand is not restored.
    arm.ctl(&["disconnect", "reader4/parameter"]).expect_code(0);
    let file = arm.home().path().join("genomd.toml");
    let planned = arm.json(&["apply", "--dry-run", "--daemon", "arm", path(&file)]);
    let wanted = serde_json::json!(["connect reader4/parameter to paper/position"]);
    assert_eq!(planned["steps"], wanted);
}

#[test]
fn the_example_gives_each_daemon_its_part() {
    let daemon = Daemon::start(&[]);
    let file = genom_tests::repository().join("configs/robot.toml");
    let steps = |name| {
        let planned = daemon.json(&["apply", "--dry-run", "--daemon", name, path(&file)]);
        planned["steps"].as_array().unwrap().len()
    };
    // Two components, a call and an activity; one component.
    assert_eq!((steps("base"), steps("arm")), (4, 1));
}

#[test]
fn the_configuration_is_printed_as_it_is_understood() {
    let home = Home::new().configured("backend = \"shm\"\n");
    let printed = home.refused(&["--dump-config", "--set", "rpc.max_streams=8"]);
    printed.expect_code(0);
    let table: toml::Table = printed.out.parse().expect("TOML");
    assert_eq!(table["backend"].as_str(), Some("shm"));
    assert_eq!(table["rpc"]["max_streams"].as_integer(), Some(8));
    // The printed text can be used as a file.
    let other = Home::new();
    std::fs::write(other.path().join("genomd.toml"), &printed.out).unwrap();
    let again = other.refused(&["--dump-config"]);
    again.expect_code(0);
    let refused = home.refused(&["--set", "rpc.max_steams=8"]);
    refused.expect_code(2).expect_err("--set rpc.max_steams=8").expect_err("`max_streams`?");
}
