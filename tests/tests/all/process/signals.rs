//! Signals to a daemon: its terminal is closed, or it is asked to stop while it starts.

use std::path::PathBuf;
use std::process::Command;

use genom_tests::{Home, Running, component, fixture, path, program, repository, request, until};
use serde_json::json;

/// A home, and a component that writes to files when it starts and when its stop codel has run.
fn home() -> (Home, String) {
    let home = Home::new();
    let late = fixture("late", "late", home.path());
    (home, late)
}

/// Runs a command on a terminal that is closed when `text` appears on it; returns after that.
fn on_a_terminal_that_closes(home: &Home, text: &str, command: &[&str]) -> Running {
    let steps = json!([{"wait": text}, {"close": true}]).to_string();
    let mut python = Command::new(std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into()));
    python.current_dir(home.path());
    python.arg(repository().join("tests/fixtures/terminal.py")).args(["80", &steps]).args(command);
    let running = Running::start(&mut python);
    running.line_where(|line| line == "closed");
    running
}

/// The command line for a daemon in this home.
fn genomd(home: &Home, arguments: &[&str]) -> Vec<String> {
    let (program, socket) = (program("genomd"), home.socket());
    let config = home.path().join("genomd.toml");
    let own = [path(&program), "--config", path(&config), "--socket", path(&socket)];
    own.iter().chain(arguments).map(|&word| word.to_owned()).collect()
}

fn let_it_start(home: &Home) {
    std::fs::write(home.path().join("go"), "").unwrap();
}

fn file(home: &Home, name: &str) -> PathBuf {
    home.path().join(name)
}

#[test]
fn the_end_of_the_terminal_stops_the_daemon_as_sigterm_does() {
    let (home, late) = home();
    let_it_start(&home);
    let command = genomd(&home, &[&late]);
    let command: Vec<&str> = command.iter().map(String::as_str).collect();
    on_a_terminal_that_closes(&home, "ready on", &command).finish().expect_code(0);
    assert!(file(&home, "ended").exists(), "its stop codel ran");
    assert!(!home.socket().exists());
}

#[test]
fn the_end_of_the_terminal_of_its_shell_stops_the_daemon() {
    let (home, late) = home();
    let_it_start(&home);
    let line = format!("{}; true", genomd(&home, &[&late]).join(" "));
    let shell = on_a_terminal_that_closes(&home, "ready on", &["sh", "-c", &line]);
    let _ = shell.finish();
    until("its stop codel ran", || file(&home, "ended").exists());
    until("it is gone", || !home.socket().exists());
}

/// Checks that the daemon survives its terminal, although it can log nowhere, and stops when asked.
#[track_caller]
fn goes_on_without_its_terminal(home: &Home, command: &[&str]) {
    let terminal = on_a_terminal_that_closes(home, "ready on", command);
    let logged = |text: &str| {
        let logs = request(&home.socket(), "GET", "/logs", "").body.to_string();
        logs.contains(text)
    };
    until("it heard of it", || logged("the terminal was closed: genomd goes on"));
    let demo = component("demo");
    let load = json!({"library": demo.library}).to_string();
    assert_eq!(request(&home.socket(), "POST", "/components", &load).status, 201);
    let goto = "/components/demo/services/goto?wait=true";
    let moved = request(&home.socket(), "POST", goto, r#"{"goal": 0.01}"#);
    assert_eq!(moved.status, 200, "{moved:?}");
    assert!(!file(home, "ended").exists());
    assert_eq!(request(&home.socket(), "POST", "/shutdown", "").status, 202);
    terminal.finish().expect_code(0);
    assert!(file(home, "ended").exists());
}

#[test]
fn with_keep_the_daemon_outlives_its_terminal() {
    let (home, late) = home();
    let_it_start(&home);
    let command = genomd(&home, &["--keep", &late]);
    let command: Vec<&str> = command.iter().map(String::as_str).collect();
    goes_on_without_its_terminal(&home, &command);
}

#[test]
fn with_nohup_the_daemon_outlives_its_terminal() {
    let (home, late) = home();
    let_it_start(&home);
    // As nohup does, but without redirecting the output.
    let line = format!("trap '' HUP; exec {}", genomd(&home, &[&late]).join(" "));
    goes_on_without_its_terminal(&home, &["sh", "-c", &line]);
}

/// A daemon with the demo in motion, and a component in a start codel that does not return.
fn starting(home: &Home, late: &str, arguments: &[&str]) -> Running {
    let demo = component("demo");
    let running = home.spawn(&[arguments, &[path(&demo.library), late]].concat());
    until("it starts", || file(home, "waits").exists());
    let goto = request(&home.socket(), "POST", "/components/demo/services/goto", r#"{"goal": 9}"#);
    assert_eq!(goto.status, 202, "{goto:?}");
    running
}

#[test]
fn sigterm_while_a_component_starts_stops_the_others_at_once_and_it_when_it_has_started() {
    let (home, late) = home();
    let running = starting(&home, &late, &[]);
    running.signal("TERM");
    let unloaded = running.error_line_where(|line| line.contains("unloaded instance=\"demo\""));
    assert!(unloaded.is_some());
    assert!(!file(&home, "ended").exists());
    let_it_start(&home);
    running.finish().expect_code(0);
    assert!(file(&home, "ended").exists(), "its stop codel ran");
    assert!(!home.socket().exists());
}

#[test]
fn a_start_codel_that_does_not_return_keeps_a_daemon_no_longer_than_a_stop_codel() {
    let (home, late) = home();
    let patience = ["--set", "stop_timeout=1", "--set", "stuck_after=1"];
    let running = starting(&home, &late, &patience);
    running.signal("TERM");
    let ended = running.finish();
    ended.expect_code(4).expect_err("codel late_wait of task second of late has not returned");
    assert!(file(&home, "ended").exists(), "the task that had started has its stop codel run");
    assert!(!home.socket().exists());
}
