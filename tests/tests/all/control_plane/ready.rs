//! A starting daemon: how it reports components that are not running yet.

use std::process::Command;

use genom_tests::{Home, Running, component, fixture, path, program, request, until};

/// A home, and a component that starts when a file `go` exists there.
fn home() -> (Home, String) {
    let home = Home::new();
    let late = fixture("late", "late", home.path());
    (home, late)
}

fn genomctl(home: &Home, arguments: &[&str]) -> Running {
    let mut command = Command::new(program("genomctl"));
    command.env_clear().arg("--socket").arg(home.socket()).args(arguments);
    Running::start(&mut command)
}

fn let_it_start(home: &Home) {
    std::fs::write(home.path().join("go"), "").unwrap();
}

#[test]
fn a_script_waits_for_a_daemon_that_is_not_there_yet_and_then_for_its_components() {
    let (home, late) = home();
    let waiting = genomctl(&home, &["wait-ready"]);
    let demo = component("demo");
    let daemon = home.spawn(&["--backend", "shm", &late, path(&demo.library)]);
    until("the component starts", || home.path().join("waits").exists());
    let ready = |query: &str| request(&home.socket(), "GET", &format!("/ready{query}"), "");
    let told = ready("");
    assert_eq!((told.status, told.code()), (503, "not_ready"));
    assert_eq!(told.body["error"]["message"], "late is being loaded, then demo");
    let listed = genomctl(&home, &["list"]).finish();
    listed.expect_code(0);
    let rows: Vec<Vec<&str>> =
        listed.out.lines().map(|line| line.split_whitespace().take(3).collect()).collect();
    assert_eq!(rows[1..], [["late", "-", "loading"], ["demo", "-", "loading"]]);
    let late_one = genomctl(&home, &["wait-ready", "--within", "0"]).finish();
    late_one.expect_code(1).expect_err("not ready after 0 s: late is being loaded, then demo");
    let_it_start(&home);
    waiting.finish().expect_code(0).expect_out("ready\n");
    // The condition it waited for holds.
    genomctl(&home, &["call", "demo", "goto", "goal=0.01"]).finish().expect_code(0);
    assert_eq!((ready("").status, ready("?deployed=true&wait=60").status), (200, 200));
    assert_eq!(ready("?wait=-1").status, 422);
    let listed = genomctl(&home, &["--json", "list"]).finish();
    assert!(!listed.out.contains("loading"), "{}", listed.out);
    daemon.signal("TERM");
    daemon.finish().expect_code(0);
}

#[test]
fn whoever_waits_for_a_daemon_that_refuses_a_component_is_told_that_it_went() {
    let (home, late) = home();
    let daemon = home.spawn(&[&late, "nothing.so"]);
    until("the component starts", || home.path().join("waits").exists());
    // If it is too late to reach the daemon, it gives up in time.
    let waiting = genomctl(&home, &["wait-ready", "--within", "2"]);
    let_it_start(&home);
    daemon.finish().expect_code(1).expect_err("no library for nothing.so");
    waiting.finish().expect_code(3);
}

#[test]
fn whoever_waits_for_no_daemon_is_told_how_to_start_one() {
    let home = Home::new();
    let waited = genomctl(&home, &["wait-ready", "--within", "0.1"]).finish();
    waited.expect_code(3).expect_err("no genomd answers on").expect_err("genomd LIBRARY...");
}

#[test]
fn connections_of_the_configuration_can_be_waited_for() {
    let demo = component("demo");
    let text = format!(
        "[[component]]\nlibrary = {:?}\n[[connection]]\nin = \"demo/parameter\"\n\
         out = \"later/position\"\n",
        demo.library
    );
    let daemon = Home::new().configured(&text).start(&["--backend", "shm"]);
    let told = request(&daemon.home().socket(), "GET", "/ready?deployed=true", "");
    assert_eq!(told.body["error"]["message"], "connections are being made");
    let waiting = daemon.spawn(&["wait-ready", "--deployed"]);
    daemon
        .ctl(&["load", path(&component("demo-2010").description), "--name", "later"])
        .expect_code(0);
    waiting.finish().expect_code(0).expect_out("ready\n");
    assert_eq!(daemon.port("demo", "parameter")["connected"], "later/position");
}
