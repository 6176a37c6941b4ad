//! Codels that do not return: what is reported, what still works, and how the daemon ends.

use std::fs;
use std::time::Duration;

use genom_tests::{Daemon, Home, component, path, request, until};
use serde_json::json;

/// A demo, and `blocks` with one of its activities in a codel that does not return.
fn hanging_in(activity: &str, arguments: &[&str]) -> Daemon {
    let (demo, blocks) = (component("demo"), component("blocks"));
    let libraries = [path(&demo.library), path(&blocks.library)];
    let daemon = Daemon::start(&[arguments, &libraries].concat());
    let mut events = daemon.events();
    daemon.ctl(&["start", "blocks", activity]).expect_code(0);
    events.wait_for(|e| e["event"] == "activity_started" && e["service"] == activity);
    daemon
}

fn hanging() -> Daemon {
    hanging_in("hang", &[])
}

/// The same, after the codel has been reported as stuck.
fn stuck_in(activity: &str, arguments: &[&str]) -> Daemon {
    let daemon = hanging_in(activity, &[&["--set", "stuck_after=1"], arguments].concat());
    until("it counts as stuck", || state(&daemon).starts_with("stuck in blocks_hang"));
    daemon
}

/// State of blocks in `list`.
fn state(daemon: &Daemon) -> String {
    let listed = daemon.json(&["list"]);
    let mut all = listed["components"].as_array().unwrap().iter();
    let found = all.find(|one| one["name"] == "blocks").unwrap();
    found["state"].as_str().unwrap().to_owned()
}

#[test]
fn a_codel_that_hangs_holds_up_nobody_else() {
    let daemon = hanging();
    daemon.ctl(&["call", "blocks", "get_count"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    daemon.ctl(&["call", "blocks", "release"]).expect_code(0);
    let (stopped, _) = daemon.stop("TERM");
    stopped.expect_code(0);
}

#[test]
fn a_stuck_codel_is_named_wherever_one_looks_until_it_returns() {
    let daemon = hanging_in("hang_steady", &[]);
    let mut events = daemon.events();
    let stuck = events.wait_for(|e| e["event"] == "codel_stuck" && e["component"] == "blocks");
    assert_eq!(
        (&stuck["codel"], &stuck["owner"]),
        (&"blocks_hang_steady".into(), &"hang_steady".into())
    );
    assert_eq!(stuck["task"], "steady");
    daemon.process().error_line_where(|line| line.contains("task steady is stuck")).unwrap();
    let overruns = || daemon.json(&["stats", "blocks"])["tasks"][1]["overruns"].as_u64().unwrap();
    let missed = overruns();
    assert!(missed > 0);
    until("ticks are missed as they come", || overruns() > missed);
    let named = "stuck in blocks_hang_steady";
    assert!(state(&daemon).starts_with(&format!("{named} for ")));
    daemon.ctl(&["stats", "blocks"]).expect_code(0).expect_err(&format!("steady is {named}"));
    let top = daemon.ctl(&["top", "--once"]);
    assert!(top.out.contains(&format!("blocks is {named}")), "{}", top.out);
    let why = daemon.ctl(&["why", "blocks/genom_state"]);
    assert!((why.out.clone() + &why.err).contains(named), "{why:?}");
    let doctor = daemon.ctl(&["doctor"]);
    doctor.expect_code(1);
    assert!(doctor.out.contains(&format!("task steady of blocks is {named}")), "{}", doctor.out);
    let activities = daemon.json(&["activities", "blocks"]);
    assert!(activities["activities"][0]["state"].as_str().unwrap().starts_with(named));
    daemon.ctl(&["call", "blocks", "release"]).expect_code(0);
    events.wait_for(|e| e["event"] == "codel_returned" && e["codel"] == "blocks_hang_steady");
    assert_eq!(state(&daemon), "running");
    let total = overruns();
    assert!(total > missed);
}

#[test]
fn what_a_stuck_codel_holds_up_is_refused_and_the_rest_goes_on() {
    let daemon = stuck_in("hang", &[]);
    let held_up = "blocks is held up: codel blocks_hang of hang has been running for ";
    daemon.ctl(&["backend", "blocks", "shm"]).expect_code(1).expect_err(held_up);
    assert_eq!(daemon.json(&["info", "blocks"])["backend"], "local", "nothing was done");
    // A complete file, followed by the message.
    let dump = daemon.json(&["dump"])["text"].as_str().unwrap().to_owned();
    let file = daemon.home().path().join("robot.toml");
    fs::write(
        &file,
        dump.replace("name = \"blocks\"", "name = \"blocks\"\nports = { genom_state = \"shm\" }"),
    )
    .unwrap();
    daemon.ctl(&["apply", path(&file)]).expect_code(1).expect_err(held_up);
    daemon.ctl(&["apply", "--dry-run", path(&file)]).expect_code(0);
    // A function that blocks: the next request waits for it.
    let socket = daemon.home().socket();
    let waiting = daemon.spawn(&["call", "blocks", "wait"]);
    until("the first is served", || {
        let stats = request(&socket, "GET", "/components", "").body;
        let stuck = stats["components"][1]["stuck"].as_array().cloned().unwrap_or_default();
        stuck.iter().any(|one| one["codel"] == "blocks_wait")
    });
    daemon.ctl(&["call", "blocks", "wait"]).expect_code(1).expect_err("is held up: codel blocks_");
    for verb in [&["ports", "blocks"][..], &["info", "blocks"], &["activities", "blocks"]] {
        daemon.ctl(verb).expect_code(0);
    }
    let recording = daemon.home().path().join("blocks.mcap");
    let record = ["record", "blocks", "--duration", "0.05", "-o", path(&recording)];
    daemon.ctl(&record).expect_code(0);
    assert_eq!(request(&socket, "GET", "/metrics", "").status, 200);
    daemon.ctl(&["abort", "blocks", "hang"]).expect_code(0);
    daemon.ctl(&["backend", "demo", "shm"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    // Both return.
    daemon.ctl(&["call", "blocks", "release"]).expect_code(0);
    daemon.ctl(&["call", "blocks", "release"]).expect_code(0);
    waiting.finish().expect_code(0);
    until("it runs again", || state(&daemon) == "running");
    daemon.ctl(&["backend", "blocks", "shm"]).expect_code(0);
    daemon.stop("TERM").0.expect_code(0);
}

#[test]
fn calls_pending_when_their_component_is_killed_end_interrupted_by_kill() {
    let blocks = component("blocks");
    let patience = ["--set", "stop_timeout=1", "--set", "stuck_after=1"];
    let daemon = Daemon::start(&[&patience[..], &[path(&blocks.library)]].concat());
    let socket = daemon.home().socket();
    let activity = daemon.spawn(&["start", "--wait", "blocks", "hang"]);
    let function = daemon.spawn(&["call", "blocks", "wait"]);
    let validation = daemon.spawn(&["call", "blocks", "wait_validate"]);
    until("all three are in their codels", || {
        let listed = request(&socket, "GET", "/components", "").body;
        listed["components"][0]["stuck"].as_array().map_or(0, Vec::len) == 3
    });
    daemon.ctl(&["call", "blocks", "kill"]).expect_code(0);
    for pending in [activity, function, validation] {
        let ended = pending.finish();
        ended.expect_code(1).expect_err("::genom::interrupted {\"by\":\"kill\"}");
    }
}

#[test]
fn after_an_unload_that_failed_the_name_is_free_and_what_is_left_is_told_until_it_ends() {
    let (home, blocks) = (Home::new(), component("blocks"));
    let file = home.path().join("go on");
    let library = path(&blocks.library).to_owned();
    let daemon = home.start(&["--backend", "shm", "--set", "stop_timeout=1", &library]);
    let input = format!("file={}", path(&file));
    daemon.ctl(&["start", "blocks", "hang_until", &input]).expect_code(0);
    until("it hangs", || {
        daemon.json(&["activities", "blocks"])["activities"][0]["state"] == "start"
    });
    let refused = daemon.ctl(&["unload", "blocks"]);
    refused
        .expect_code(1)
        .expect_err("codel blocks_hang_until of hang_until has been running for ");
    refused.expect_err("the name blocks is free again");
    let left = || daemon.json(&["list"])["left_behind"].clone();
    assert_eq!(left()[0]["was"], "blocks");
    let doctor = daemon.ctl(&["doctor"]);
    assert!(doctor.out.contains("left behind: stuck in blocks_hang_until"), "{}", doctor.out);
    // Name, ports and services are available as if nothing had happened.
    daemon.ctl(&["load", &library]).expect_code(0);
    daemon.ctl(&["call", "blocks", "get_count"]).expect_code(0);
    daemon.ctl(&["backend", "blocks", "local"]).expect_code(0);
    fs::write(&file, "").unwrap();
    until("what was left behind is gone", || left().is_null());
    daemon.process().error_line_where(|line| line.contains("has ended, and is gone")).unwrap();
    daemon.ctl(&["call", "blocks", "get_count"]).expect_code(0);
    daemon.stop("TERM").0.expect_code(0);
}

#[test]
fn how_an_activity_ends_is_learnt_also_while_its_component_is_unloaded() {
    let (home, blocks) = (Home::new(), component("blocks"));
    let file = home.path().join("go on");
    let daemon = home.start(&["--set", "stop_timeout=60", path(&blocks.library)]);
    let input = format!("file={}", path(&file));
    daemon.ctl(&["start", "blocks", "hang_until", &input]).expect_code(0);
    let unload = daemon.spawn(&["unload", "blocks"]);
    until("it is being unloaded", || daemon.json(&["list"])["components"] == json!([]));
    let look = ["wait", "blocks", "hang_until", "--timeout", "0.01"];
    daemon.ctl(&look).expect_code(1).expect_err("still runs after 0.01 s");
    daemon.ctl(&["call", "blocks", "get_count"]).expect_code(1).expect_err("no component `blocks`");
    fs::write(&file, "").unwrap();
    unload.finish().expect_code(0);
    daemon.ctl(&look).expect_code(1).expect_err("no component `blocks`");
    daemon.stop("TERM").0.expect_code(0);
}

#[test]
fn signals_that_come_together_are_one_wish_and_stop_codels_run() {
    let daemon = Daemon::demo("local");
    let mut events = daemon.events();
    daemon.ctl(&["start", "demo", "goto", "goal=10"]).expect_code(0);
    events.wait_for(|e| e["state"] == "main" && e["paused"] == true);
    // So fast that it needs several periods to stop.
    let echo = daemon.spawn(&["echo", "demo/position", "--rate", "200"]);
    echo.line_where(|line| line.contains("\"velocity\":0.5"));
    drop(echo);
    for signal in ["INT", "TERM", "TERM"] {
        daemon.process().signal(signal);
    }
    let (stopped, _) = daemon.finish();
    stopped.expect_code(0);
    events.wait_for(|e| e["event"] == "transition" && e["state"] == "stop");
    events.wait_for(|e| e["event"] == "activity_ended");
    events.wait_for(|e| e["event"] == "component_unloaded");
}

#[test]
fn another_signal_after_a_while_ends_a_daemon_whose_codels_hang() {
    let daemon = hanging_in("hang", &["--set", "stop_timeout=3600"]);
    until("it ends", || {
        daemon.process().signal("TERM");
        !daemon.home().socket().exists()
    });
    let (stopped, home) = daemon.finish();
    stopped.expect_code(4).expect_err("stopped before all codels had ended: blocks");
    assert!(!home.socket().exists());
}

#[test]
fn five_that_hang_take_one_time_out_and_the_others_stop_first() {
    let (demo, blocks) = (component("demo"), component("blocks"));
    let daemon = Daemon::start(&["--set", "stop_timeout=3", path(&demo.library)]);
    for n in 0..5 {
        let name = format!("b{n}");
        daemon.ctl(&["load", path(&blocks.library), "--name", &name]).expect_code(0);
        daemon.ctl(&["start", &name, "hang"]).expect_code(0);
    }
    daemon.ctl(&["start", "demo", "goto", "goal=10"]).expect_code(0);
    let mut events = daemon.events();
    daemon.process().signal("TERM");
    let told =
        events.wait_for(|e| e["event"] == "component_unloaded" || e["event"] == "component_left");
    assert_eq!(told["component"], "demo", "{told}");
    // One after the other they would take 15 s.
    let (stopped, _) = daemon.finish_within(Duration::from_secs(14));
    stopped.expect_code(4);
    for n in 0..5 {
        stopped.expect_err(&format!("b{n} (codel blocks_hang of hang, for "));
    }
}
