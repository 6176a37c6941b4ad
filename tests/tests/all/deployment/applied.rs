//! Deployment files: to whom they apply, what may run besides, what they change, and how mistakes
//! are reported.

use genom_tests::{Daemon, Home, component, path};
use serde_json::json;

/// Demos for two daemons; a daemon may be named or not.
fn demos(daemons: [&str; 2]) -> String {
    let library = component("demo").library;
    let one = |name: &str, daemon: &str| {
        let daemon = match daemon {
            "" => String::new(),
            daemon => format!("daemon = {daemon:?}\n"),
        };
        format!("[[component]]\nlibrary = {library:?}\nname = {name:?}\n{daemon}")
    };
    one("left", daemons[0]) + &one("right", daemons[1])
}

fn write(daemon: &Daemon, text: &str) -> String {
    let file = daemon.home().path().join("robot.toml");
    std::fs::write(&file, text).unwrap();
    path(&file).to_owned()
}

/// The in port of `left`, connected to the paper's component.
fn wired() -> String {
    let paper = component("demo-2010").description;
    format!("{}[[component]]\nlibrary = {paper:?}\nname = \"paper\"\n", demos(["", ""]))
        + "[[connection]]\nin = \"left/parameter\"\nout = \"paper/position\"\n"
}

#[test]
fn a_file_of_several_daemons_is_nothing_for_one_that_it_does_not_name() {
    let text = demos(["base", "arm"]);
    for (given, told) in [
        (&["--daemon", "bse"][..], "no daemon `bse`; say with --daemon which of these it is"),
        (&[], "several daemons; say with --daemon which of these it is: arm, base"),
    ] {
        let refused = Home::new().configured(&text).refused(given);
        refused.expect_code(2).expect_err(told);
        let daemon = Daemon::start(&[]);
        let refused = daemon.ctl(&[&["apply", &write(&daemon, &text)], given].concat());
        refused.expect_code(1).expect_err(told);
        assert_eq!(daemon.json(&["list"])["components"], json!([]));
    }
    // By the name with which it was started.
    let daemon = Home::new().start(&["--daemon", "arm"]);
    daemon.ctl(&["apply", &write(&daemon, &text)]).expect_code(0);
    assert_eq!(daemon.json(&["list"])["components"][0]["name"], "right");
}

#[test]
fn what_runs_beside_a_file_is_told_and_taken_away_on_request() {
    let daemon = Daemon::start(&[]);
    daemon.ctl(&["apply", &write(&daemon, &wired())]).expect_code(0);
    let only = write(&daemon, &demos(["", ""]));
    let told = daemon.ctl(&["apply", &only]);
    told.expect_code(0).expect_out(
        "nothing to do: all that the file says is so\n\
         beside the file: connection left/parameter to paper/position, component paper; \
         --prune takes that away\n",
    );
    let planned = daemon.json(&["apply", "--prune", "--dry-run", &only]);
    let steps = json!(["disconnect left/parameter to paper/position", "unload paper"]);
    assert_eq!(planned["steps"], steps);
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 3);
    assert_eq!(daemon.json(&["apply", "--prune", &only])["steps"], steps);
    assert_eq!(daemon.json(&["list"])["components"].as_array().unwrap().len(), 2);
    assert_eq!(daemon.json(&["connections"])["connections"], json!([]));
    // The declaration is gone, too.
    let paper = component("demo-2010").description;
    daemon.ctl(&["load", path(&paper), "--name", "paper"]).expect_code(0);
    daemon.ctl(&["unload", "paper"]).expect_code(0);
    let again = daemon.ctl(&["apply", "--prune", &only]);
    again.expect_out("nothing to do: everything is as the file says\n");
}

#[test]
fn other_settings_of_tasks_load_a_component_anew_and_keep_what_it_had() {
    let daemon = Daemon::start(&[]);
    daemon.ctl(&["apply", &write(&daemon, &wired())]).expect_code(0);
    daemon.ctl(&["call", "left", "set_speed", "velocity=0.75"]).expect_code(0);
    let period = |daemon: &Daemon| daemon.json(&["stats", "left"])["tasks"][0]["period_ns"].clone();
    assert_eq!(period(&daemon), 5_000_000);
    let changed = wired().replacen("\"left\"\n", "\"left\"\ntasks.main.period_ms = 4.0\n", 1);
    let steps =
        json!(
            ["reload left: other settings of tasks", "connect left/parameter to paper/position",]
        );
    let file = write(&daemon, &changed);
    assert_eq!(daemon.json(&["apply", "--dry-run", &file])["steps"], steps);
    assert_eq!(daemon.json(&["apply", &file])["steps"], steps);
    assert_eq!(period(&daemon), 4_000_000);
    daemon.ctl(&["call", "left", "get_speed"]).expect_out("velocity = 0.75\n");
    assert_eq!(daemon.port("left", "parameter")["connected"], "paper/position");
    daemon.ctl(&["apply", &file]).expect_out("nothing to do: everything is as the file says\n");

    // If a later step is refused, the state is as before.
    let wrong = changed.replace("period_ms = 4.0", "period_ms = 2.0")
        + "[[call]]\ncomponent = \"right\"\nservice = \"goto\"\ninputs = { goal = 99.0 }\n";
    daemon.ctl(&["apply", &write(&daemon, &wrong)]).expect_code(1).expect_err("OUT_OF_RANGE");
    assert_eq!(period(&daemon), 4_000_000);
    daemon.ctl(&["call", "left", "get_speed"]).expect_out("velocity = 0.75\n");
    assert_eq!(daemon.port("left", "parameter")["connected"], "paper/position");
}

#[test]
fn a_dump_has_the_options_of_the_middlewares() {
    let daemon = Daemon::demo("shm");
    let dumped: toml::Table = daemon.ctl(&["dump"]).out.parse().expect("TOML");
    assert_eq!(dumped["backend"].as_str(), Some("shm"));
    let prefix = daemon.home().memory().prefix().to_owned();
    assert_eq!(dumped["backends"]["shm"]["prefix"].as_str(), Some(prefix.as_str()));
    // A daemon starts from it, in the place of the first one.
    let (_, home) = daemon.stop("TERM");
    std::fs::write(home.path().join("genomd.toml"), toml::to_string(&dumped).unwrap()).unwrap();
    let again = home.start(&[]);
    assert_eq!(again.json(&["list"])["components"][0]["backend"], "shm");
}

#[test]
fn what_is_refused_is_told_with_its_line() {
    let library = component("demo").library;
    let one = format!("[[component]]\nlibrary = {library:?}\nname = \"left\"\n");
    let twice = "[[connection]]\nin = \"left/parameter\"\nout = \"a/b\"\n".repeat(2);
    for (text, told) in [
        (format!("log = \"loud\"\n{one}"), "robot.toml:1: `loud` is no level of logs"),
        (format!("log = \"inof\"\n{one}"), "did you mean `info`?"),
        (format!("{one}{twice}"), "robot.toml:8: a second connection into left/parameter"),
        (
            format!("{one}[[activity]]\ncomponent = \"left\"\nservice = \"reset\"\n"),
            "robot.toml:6: activity.service: start left/reset {}: left/reset is a function: name \
             it in [[call]]",
        ),
    ] {
        let daemon = Daemon::start(&[]);
        daemon.ctl(&["apply", &write(&daemon, &text)]).expect_code(1).expect_err(told);
        assert_eq!(daemon.json(&["list"])["components"], json!([]));
        let home = Home::new().configured(&text);
        let refused = home.refused(&[]);
        assert_ne!(refused.code, Some(0));
        refused.expect_err(&told.replace("robot.toml", "genomd.toml"));
    }
    let refused = Home::new().refused(&["--log", "loud"]);
    refused.expect_code(2).expect_err("--log `loud` is no level of logs");
}

#[test]
fn a_component_that_is_loaded_anew_keeps_what_the_file_leaves_out_of_an_attribute() {
    let daemon = Daemon::start(&[]);
    let library = component("mission").library;
    let text = |period: &str| {
        format!(
            "[[component]]\nlibrary = {library:?}\n[component.attributes]\n\
             set_turns = {{ turns = {{ far = 0.25 }} }}\n[component.tasks.watch]\n\
             period_ms = {period}\n"
        )
    };
    daemon.ctl(&["apply", &write(&daemon, &text("5.0"))]).expect_code(0);
    daemon.ctl(&["call", "mission", "set_turns", "turns.near=-1"]).expect_code(0);
    let again = daemon.ctl(&["apply", &write(&daemon, &text("5.0"))]);
    again.expect_out("nothing to do: everything is as the file says\n");
    let steps = daemon.json(&["apply", &write(&daemon, &text("4.0"))])["steps"].clone();
    assert_eq!(steps, json!(["reload mission: other settings of tasks"]));
    let turns = daemon.json(&["info", "mission", "set_turns"])["parameters"][0]["current"].clone();
    assert_eq!(turns, json!({"near": -1.0, "far": 0.25}));
}
