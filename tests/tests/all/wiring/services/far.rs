//! The service is in another daemon: found and called through a middleware that both use.

use std::sync::Arc;
use std::time::Instant;

use genom_tests::{Daemon, Finished, Home, Memory, WATCHDOG, component, path};
use tempfile::TempDir;

use super::make;

/// A daemon with the caller, one with the provider, and what is needed to start another provider.
struct Pair {
    caller: Daemon,
    provider: Option<Daemon>,
    backend: &'static str,
    memory: Arc<Memory>,
    files: TempDir,
}

impl Pair {
    fn new(backend: &'static str) -> Self {
        let (memory, files) = (Arc::new(Memory::new()), tempfile::tempdir().unwrap());
        let caller = make("caller", files.path());
        let caller = Home::with(&memory).start(&["--backend", backend, &caller]);
        let mut pair = Self { caller, provider: None, backend, memory, files };
        pair.provide("provider");
        pair
    }

    /// Starts a daemon that has this component as `provider`.
    fn provide(&mut self, component: &str) {
        let description = make(component, self.files.path());
        let arguments = ["--backend", self.backend, "--name", "provider", &description];
        self.provider = Some(Home::with(&self.memory).start(&arguments));
    }

    /// Kills the provider's daemon.
    fn kill(&mut self) {
        let killed = self.provider.take().unwrap().stop("KILL").0;
        assert_eq!(killed.code, None);
    }

    fn connect(&self, service: &str) -> Finished {
        self.caller.ctl(&["connect", "caller/add", service])
    }

    /// Connects a remote as soon as the service is visible.
    fn connect_when_there(&self, remote: &str, service: &str) -> Finished {
        let end = Instant::now() + WATCHDOG;
        loop {
            let made = self.caller.ctl(&["connect", remote, service]);
            if !made.err.contains("no_such_service") {
                return made;
            }
            assert!(Instant::now() < end, "{}: {made:?}", self.backend);
        }
    }

    fn ask(&self, a: &str) -> Finished {
        self.caller.ctl(&["call", "caller", "ask", &format!("a={a}"), "b=2"])
    }

    /// Calls until the result is as expected, since other daemons become visible with a delay.
    fn ask_until(&self, expected: impl Fn(&Finished) -> bool) {
        let end = Instant::now() + WATCHDOG;
        loop {
            let answer = self.ask("1");
            if expected(&answer) {
                return;
            }
            assert!(Instant::now() < end, "{}: {answer:?}", self.backend);
        }
    }
}

fn calls(backend: &'static str) {
    let pair = Pair::new(backend);
    pair.ask("1").expect_code(1).expect_err("::genom::no_such_service");
    let made = pair.connect_when_there("caller/add", "provider/add");
    made.expect_code(0).expect_out(&format!("caller/add calls provider/add ({backend})\n"));
    pair.ask("1").expect_code(0).expect_out("sum = 3\n");
    pair.ask("1001").expect_code(1).expect_err(r#"::adder::TOO_LARGE {"limit":1000}"#);
    let listed = pair.caller.json(&["connections"]);
    assert_eq!(listed["connections"][0]["backend"], backend, "{listed}");
    // GenoM3's own service does the same (genom3.md 4.8), also with the middleware named.
    pair.caller.ctl(&["disconnect", "caller/add"]).expect_code(0);
    let inputs = format!(r#"{{"local":"add","remote":"{backend}:provider/add"}}"#);
    pair.caller.ctl(&["call", "caller", "connect_service", &inputs]).expect_code(0);
    pair.ask("40").expect_code(0).expect_out("sum = 42\n");
}

#[test]
fn calls_follow_a_service_that_moves_to_another_middleware() {
    let pair = Pair::new("shm");
    pair.connect_when_there("caller/add", "provider/add").expect_code(0);
    pair.caller.ctl(&["backend", "caller", "zenoh"]).expect_code(0);
    // It does not exist yet, so the previous service is called.
    pair.ask("1").expect_code(0).expect_out("sum = 3\n");
    let provider = pair.provider.as_ref().unwrap();
    provider.ctl(&["backend", "provider", "zenoh"]).expect_code(0);
    pair.ask_until(|answer| answer.out == "sum = 3\n");
    let listed = pair.caller.json(&["connections"]);
    assert_eq!(listed["connections"][0]["backend"], "zenoh", "{listed}");
}

fn refuses(backend: &'static str) {
    let pair = Pair::new(backend);
    pair.connect_when_there("caller/add", "provider/add").expect_code(0);
    let refused = pair.connect("provider/ad");
    refused.expect_code(1).expect_err("no_such_service").expect_err(&format!("on {backend}"));
    refused.expect_err("did you mean `provider/add`?");
    // genom3.md 4.9: the message names both with their digests.
    let demo = component("demo");
    pair.provider.as_ref().unwrap().ctl(&["load", path(&demo.library)]).expect_code(0);
    let refused = pair.connect_when_there("caller/add", "demo/reset");
    refused.expect_code(1).expect_err("add of interface adder").expect_err("::demo::reset");
    refused.expect_err("digest").expect_err("make the two .gen interfaces equal");
    // The previous connection is unchanged.
    pair.ask("1").expect_code(0).expect_out("sum = 3\n");
}

fn survives(backend: &'static str) {
    let mut pair = Pair::new(backend);
    pair.connect_when_there("caller/add", "provider/add").expect_code(0);
    pair.connect_when_there("caller/stay", "provider/stay").expect_code(0);
    pair.ask("1").expect_code(0);
    // A call in progress ends when the other daemon dies.
    let joining = pair.caller.spawn(&["call", "caller", "join"]);
    assert_eq!(pair.provider.as_ref().unwrap().process().line(), "stays");
    pair.kill();
    joining.finish().expect_code(1).expect_err("::genom::remote_io");
    // Calls fail with a clear message while nobody serves; afterwards they work again without a
    // command.
    pair.ask_until(|answer| answer.err.contains("::genom::no_such_service"));
    pair.provide("provider");
    pair.ask_until(|answer| answer.out == "sum = 3\n");
    // Another interface under the same name is refused (genom3.md 4.9), even if only its exceptions
    // differ.
    pair.kill();
    pair.ask_until(|answer| answer.err.contains("::genom::no_such_service"));
    pair.provide("liar");
    pair.ask_until(|answer| answer.err.contains("::genom::incompatible_digest"));
}

/// A call in progress ends when the component that serves it is killed, although its codel never
/// returns.
fn is_told_of_a_kill(backend: &'static str) {
    let pair = Pair::new(backend);
    pair.connect_when_there("caller/stay", "provider/stay").expect_code(0);
    let joining = pair.caller.spawn(&["call", "caller", "join"]);
    let provider = pair.provider.as_ref().unwrap();
    assert_eq!(provider.process().line(), "stays");
    let killed = provider.spawn(&["call", "provider", "kill"]);
    joining.finish().expect_code(1).expect_err(r#"::genom::interrupted {"by":"kill"}"#);
    killed.finish().expect_code(0);
}

#[test]
fn who_calls_a_component_that_is_killed_is_told_over_shm() {
    is_told_of_a_kill("shm");
}

#[test]
fn who_calls_a_component_that_is_killed_is_told_over_zenoh() {
    is_told_of_a_kill("zenoh");
}

#[test]
fn a_codel_calls_a_service_of_another_daemon_over_shm() {
    calls("shm");
}

#[test]
fn a_codel_calls_a_service_of_another_daemon_over_zenoh() {
    calls("zenoh");
}

#[test]
fn a_service_of_another_daemon_that_differs_is_refused_with_both_named_over_shm() {
    refuses("shm");
}

#[test]
fn a_service_of_another_daemon_that_differs_is_refused_with_both_named_over_zenoh() {
    refuses("zenoh");
}

#[test]
fn a_daemon_that_dies_is_an_exception_until_it_is_back_over_shm() {
    survives("shm");
}

#[test]
fn a_daemon_that_dies_is_an_exception_until_it_is_back_over_zenoh() {
    survives("zenoh");
}

#[test]
fn a_service_that_comes_later_is_waited_for() {
    let (memory, files) = (Arc::new(Memory::new()), tempfile::tempdir().unwrap());
    let caller = make("caller", files.path());
    let caller = Home::with(&memory).start(&["--backend", "shm", &caller]);
    let mut pair = Pair { caller, provider: None, backend: "shm", memory, files };
    pair.connect("provider/add").expect_code(1).expect_err("--wait");
    pair.caller.ctl(&["connect", "--wait", "caller/add", "shm:provider/add"]).expect_code(0);
    pair.ask("1").expect_code(1).expect_err("::genom::no_such_service");
    pair.provide("provider");
    pair.ask("1").expect_code(0).expect_out("sum = 3\n");
}

#[test]
fn a_component_on_local_calls_no_other_daemon() {
    let files = tempfile::tempdir().unwrap();
    let caller = Daemon::start(&[&make("caller", files.path())]);
    let refused = caller.ctl(&["connect", "caller/add", "provider/add"]);
    refused.expect_code(1).expect_err("local calls no other").expect_err("there are: caller");
    let refused = caller.ctl(&["connect", "caller/add", "smh:provider/add"]);
    refused.expect_code(1).expect_err("did you mean `shm`?");
}
