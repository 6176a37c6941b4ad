//! One component calls a service of another, after a supervisor has connected them.

mod deployed;
mod far;

use std::path::Path;
use std::process::Command;

use genom_tests::{Daemon, Running, fixture, program};
use serde_json::Value;

/// Builds one of the components in a directory.
fn make(name: &str, into: &Path) -> String {
    fixture("adders", name, into)
}

fn pair(backend: &str) -> (Daemon, tempfile::TempDir) {
    let scratch = tempfile::tempdir().unwrap();
    let (provider, caller) = (make("provider", scratch.path()), make("caller", scratch.path()));
    (Daemon::start(&["--backend", backend, &provider, &caller]), scratch)
}

#[test]
fn a_codel_calls_the_service_that_its_remote_is_connected_to() {
    for backend in ["local", "shm"] {
        let (daemon, files) = pair(backend);
        let ask = |a: &str, b: &str| {
            daemon.ctl(&["call", "caller", "ask", &format!("a={a}"), &format!("b={b}")])
        };
        ask("1", "2").expect_code(1).expect_err("::genom::no_such_service");
        let made = daemon.ctl(&["connect", "caller/add", "provider/add"]);
        made.expect_code(0).expect_out("caller/add calls provider/add\n");
        ask("1", "2").expect_code(0).expect_out("sum = 3\n");
        // An exception of the service reaches the calling codel, with its detail.
        ask("1001", "2").expect_code(1).expect_err(r#"::adder::TOO_LARGE {"limit":1000}"#);
        // The provider may be unloaded and loaded again.
        daemon.ctl(&["unload", "provider"]).expect_code(0);
        ask("1", "2").expect_code(1).expect_err("::genom::no_such_service");
        // Another component of that name is refused: its exceptions differ (genom3.md 4.9).
        let liar = make("liar", files.path());
        daemon.ctl(&["load", &liar, "--name", "provider"]).expect_code(0);
        ask("1", "2").expect_code(1).expect_err("::genom::incompatible_digest");
        daemon.ctl(&["disconnect", "caller/add"]).expect_code(0);
        assert_eq!(daemon.json(&["connections"])["connections"], Value::Array(Vec::new()));
    }
}

#[test]
fn a_remote_is_connected_to_its_like_only() {
    let (daemon, _files) = pair("local");
    let refused = daemon.ctl(&["connect", "caller/add", "provider/ad"]);
    refused.expect_code(1).expect_err("did you mean `add`?");
    let refused = daemon.ctl(&["connect", "caller/add", "provider/kill"]);
    refused.expect_code(1).expect_err("make the two .gen interfaces equal");
    let refused = daemon.ctl(&["connect", "caller/add", "provider/add", "--policy", "latest"]);
    refused.expect_code(1).expect_err("it takes a service, and no policy");
    // GenoM3's own service does the same (genom3.md 4.8).
    let connect = |remote: &str| {
        let inputs = format!(r#"{{"local":"add","remote":"{remote}"}}"#);
        daemon.ctl(&["call", "caller", "connect_service", &inputs])
    };
    connect("provider/nothing").expect_code(1).expect_err("::genom::no_such_service");
    connect("provider/add").expect_code(0);
    daemon.ctl(&["call", "caller", "ask", "a=20", "b=22"]).expect_out("sum = 42\n");
    let listed = daemon.json(&["connections"]);
    assert_eq!(listed["connections"][0]["kind"], "service", "{listed}");
}

/// What shell completion offers for the last word.
fn offered(daemon: &Daemon, words: &[&str]) -> String {
    let mut command = Command::new(program("genomctl"));
    command.env_clear().env("GENOMD_SOCKET", daemon.home().socket());
    command.env("GENOMCTL_COMPLETE", "fish").args(["--", "genomctl"]).args(words);
    Running::start(&mut command).finish().out
}

#[test]
fn remotes_are_completed_and_it_is_told_why_they_call_nothing() {
    let (daemon, _files) = pair("local");
    assert_eq!(offered(&daemon, &["connect", "caller/a"]), "caller/add\tremote\n");
    let services = offered(&daemon, &["connect", "caller/add", "provider/a"]);
    assert!(services.starts_with("provider/add"), "{services}");
    let why = |told: &str| {
        daemon.ctl(&["why", "caller/add"]).expect_code(0).expect_out(told);
    };
    why("caller/add is not connected\n  \
         fix: `genomctl connect caller/add COMPONENT/SERVICE`\n");
    daemon.ctl(&["connect", "caller/add", "provider/add"]).expect_code(0);
    why("data flows: nothing is wrong\n");
    assert!(offered(&daemon, &["disconnect", "caller/"]).starts_with("caller/add"));
    daemon.ctl(&["unload", "provider"]).expect_code(0);
    why("nobody provides provider/add in this daemon\n  \
         fix: start its component; the connection is still there\n");
}
