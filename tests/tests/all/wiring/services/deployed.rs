//! Remotes in deployment files: connected with the rest, planned, dumped, kept.

use std::path::Path;
use std::sync::Arc;

use genom_tests::{Daemon, Home, Memory, path, until_answer};
use serde_json::json;

use super::make;

/// The caller, the provider and the connection between them; in one daemon or in one each.
fn file(files: &Path, backend: &str, apart: bool) -> String {
    let of = |daemon: &str| if apart { format!("daemon = {daemon:?}\n") } else { String::new() };
    format!(
        "backend = {backend:?}\n[[component]]\nlibrary = {:?}\n{}[[connection]]\n\
         in = \"caller/add\"\nout = \"provider/add\"\n[[component]]\nlibrary = {:?}\n{}",
        make("caller", files),
        of("caller"),
        make("provider", files),
        of("provider"),
    )
}

fn write(daemon: &Daemon, text: &str) -> String {
    let file = daemon.home().path().join("robot.toml");
    std::fs::write(&file, text).unwrap();
    path(&file).to_owned()
}

fn sum(daemon: &Daemon) -> String {
    daemon.ctl(&["call", "caller", "ask", "a=20", "b=22"]).out
}

#[test]
fn a_remote_in_a_file_is_planned_connected_dumped_and_connected_again() {
    let files = tempfile::tempdir().unwrap();
    let daemon = Daemon::start(&[]);
    let text = file(files.path(), "shm", false);
    let robot = write(&daemon, &text);
    let plan =
        |daemon: &Daemon, file: &str| daemon.json(&["apply", "--dry-run", file])["steps"].clone();
    assert_eq!(plan(&daemon, &robot)[2], "connect caller/add to provider/add");
    daemon.ctl(&["apply", &robot]).expect_code(0);
    assert_eq!(sum(&daemon), "sum = 42\n");
    assert_eq!(plan(&daemon, &robot), json!([]));

    // A dump of what runs has the same effect elsewhere.
    let dumped = daemon.ctl(&["dump"]).out;
    let fresh = Daemon::start(&[]);
    fresh.ctl(&["apply", &write(&fresh, &dumped)]).expect_code(0);
    // Without the options of its own middlewares.
    let runs = |dump: &str| dump[dump.find("[[component]]").unwrap()..].to_owned();
    assert_eq!(runs(&fresh.ctl(&["dump"]).out), runs(&dumped));
    assert_eq!(sum(&fresh), "sum = 42\n");

    // The caller is unloaded and loaded again: it is connected without a command.
    daemon.ctl(&["unload", "caller"]).expect_code(0);
    let caller = files.path().join("caller.gen");
    daemon.ctl(&["load", path(&caller), "--backend", "shm"]).expect_code(0);
    until_answer("sum = 42\n", || sum(&daemon));
    // A connection that was ended by hand is not restored.
    daemon.ctl(&["disconnect", "caller/add"]).expect_code(0);
    assert_eq!(plan(&daemon, &robot), json!(["connect caller/add to provider/add"]));
    assert!(!daemon.ctl(&["dump"]).out.contains("connection"));
}

#[test]
fn a_remote_that_cannot_be_connected_takes_the_deployment_back() {
    let files = tempfile::tempdir().unwrap();
    let daemon = Daemon::start(&[]);
    let text = file(files.path(), "shm", false);
    make("liar", files.path());
    for (from, to, told) in [
        ("\"provider/add\"", "\"provider/ad\"", "robot.toml:6: connection.out: "),
        ("\"provider/add\"", "\"provider/ad\"", "did you mean `add`?"),
        ("\"caller/add\"", "\"caller/ad\"", "robot.toml:5: connection.in: "),
        ("\"provider/add\"", "\"provider/kill\"", "make the two .gen interfaces equal"),
        ("\"provider/add\"", "\"provider/add\"\npolicy = \"latest\"", "and no policy"),
        ("\"provider/add\"", "\"nobody/add\"", "nothing after "),
    ] {
        let text = text.replacen(from, to, 1);
        let refused = daemon.ctl(&["apply", "--timeout", "0.1", &write(&daemon, &text)]);
        refused.expect_code(1).expect_err(told).expect_err("everything is as it was before");
        assert_eq!(daemon.json(&["list"])["components"], json!([]), "{to}");
    }
}

fn apart(backend: &'static str) {
    let (memory, files) = (Arc::new(Memory::new()), tempfile::tempdir().unwrap());
    let text = file(files.path(), backend, true);
    let start = |name| Home::with(&memory).configured(&text).start(&["--daemon", name]);
    // The caller is started first, and waits for the service.
    let caller = start("caller");
    let line = caller.process().error_line_where(|line| line.contains("waiting to connect"));
    assert!(line.is_some_and(|line| line.contains("caller/add to provider/add")));
    let provider = start("provider");
    let line = caller.process().error_line_where(|line| line.contains("deployed:"));
    assert!(line.is_some(), "the daemon ended");
    let made = caller.json(&["connections"])["connections"].clone();
    assert_eq!((&made[0]["kind"], &made[0]["backend"]), (&json!("service"), &json!(backend)));
    until_answer("sum = 42\n", || sum(&caller));

    // The provider's daemon is killed and started again.
    let (_, home) = provider.stop("KILL");
    let _provider = home.start(&["--daemon", "provider"]);
    until_answer("sum = 42\n", || sum(&caller));
    // The same with the caller's.
    let (_, home) = caller.stop("KILL");
    let caller = home.start(&["--daemon", "caller"]);
    until_answer("sum = 42\n", || sum(&caller));
}

#[test]
fn a_remote_of_a_file_calls_another_daemon_and_does_so_again_after_a_crash_over_shm() {
    apart("shm");
}

#[test]
fn a_remote_of_a_file_calls_another_daemon_and_does_so_again_after_a_crash_over_zenoh() {
    apart("zenoh");
}
