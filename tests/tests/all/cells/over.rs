//! Connections between processes of a daemon over a middleware that is asked for.

use genom_tests::{Daemon, Home, component, path, until};

use super::{load, signal};

/// The writer, the paper's component, and two readers, each in the daemon's process or in a cell.
fn placed(paper: &[&str], demo: &[&str]) -> Daemon {
    let at_once = "[cells]\nrestart_delay = 0.0\n";
    let daemon = Home::new().configured(at_once).start(&["--backend", "local"]);
    load(&daemon, "demo", demo);
    load(&daemon, "demo", &["--name", "two", "--cell", "second"]);
    let description = component("demo-2010").description;
    let paper = [&["load", path(&description), "--name", "paper"], paper].concat();
    daemon.ctl(&paper).expect_code(0);
    daemon
}

fn writer_is_on(daemon: &Daemon) -> String {
    let ports = daemon.ctl(&["--json", "ports", "paper"]);
    let Ok(reply) = serde_json::from_str::<serde_json::Value>(&ports.out) else {
        return String::new();
    };
    let mut ports = reply["ports"].as_array().into_iter().flatten();
    let port = ports.find(|port| port["name"] == "position");
    port.and_then(|port| port["backend"].as_str()).unwrap_or_default().to_owned()
}

fn connect(daemon: &Daemon, reader: &str, over: &str) {
    let inport = format!("{reader}/parameter");
    let made = daemon.ctl(&["connect", &inport, "paper/position", "--over", over]);
    made.expect_code(0);
    made.expect_out(&format!("{inport} reads paper/position ({over}, latest)\n"));
}

fn disconnect(daemon: &Daemon, reader: &str) {
    daemon.ctl(&["disconnect", &format!("{reader}/parameter")]).expect_code(0);
}

/// The reader gets what the writer writes next.
fn flows(daemon: &Daemon, reader: &str, position: f64) {
    until("the value arrives", || {
        // A cell that is not back yet refuses.
        let _ = daemon.ctl(&["call", "paper", "goto", &format!("position={position}")]);
        let _ = daemon.ctl(&["call", reader, "goto", "goal=0.01"]);
        let _ = daemon.ctl(&["call", reader, "goto", "goal=0"]);
        daemon.port(reader, "parameter")["value"] == position
    });
}

/// Connects both readers over zenoh, and disconnects them again.
fn opened_and_closed(daemon: &Daemon, own: &str) {
    let both = format!("{own}+zenoh");
    connect(daemon, "demo", "zenoh");
    assert_eq!(writer_is_on(daemon), both);
    connect(daemon, "two", "zenoh");
    flows(daemon, "demo", 0.25);
    flows(daemon, "two", 0.5);
    disconnect(daemon, "two");
    flows(daemon, "demo", 0.75);
    assert_eq!(writer_is_on(daemon), both);
    disconnect(daemon, "demo");
    until("the end is closed", || writer_is_on(daemon) == own);
}

#[test]
fn a_port_in_a_cell_is_opened_for_readers_in_the_daemon_and_in_another_cell() {
    let daemon = placed(&["--cell", "first"], &[]);
    opened_and_closed(&daemon, "shm");
}

#[test]
fn a_port_in_the_daemon_is_opened_for_readers_in_cells() {
    let daemon = placed(&[], &["--cell", "first"]);
    opened_and_closed(&daemon, "local");
}

#[test]
fn a_port_in_a_cell_is_opened_for_a_reader_in_the_same_cell() {
    let daemon = placed(&["--cell", "first"], &["--cell", "first"]);
    opened_and_closed(&daemon, "shm");
}

#[test]
fn a_middleware_that_leaves_no_process_is_refused_between_two() {
    let daemon = placed(&["--cell", "first"], &[]);
    for reader in ["demo/parameter", "two/parameter"] {
        let refused = daemon.ctl(&["connect", reader, "paper/position", "--over", "local"]);
        refused
            .expect_code(1)
            .expect_err("run in different processes, and local does not leave one");
        let refused = daemon.ctl(&["connect", reader, "paper/position", "--over", "zeno"]);
        refused.expect_code(1).expect_err("did you mean `zenoh`?");
        let refused = daemon.ctl(&["connect", reader, "two/position", "--over", "zenoh"]);
        refused.expect_code(1).expect_err("demo::state");
    }
    assert_eq!(writer_is_on(&daemon), "shm");
    until("nothing stays open", || daemon.port("two", "position")["backend"] == "shm");
}

#[test]
fn a_writer_whose_cell_was_killed_is_read_over_the_same_middleware() {
    let daemon = placed(&["--cell", "first"], &[]);
    connect(&daemon, "demo", "zenoh");
    connect(&daemon, "two", "zenoh");
    signal(&daemon, "first", "KILL");
    until("the end is open again", || writer_is_on(&daemon) == "shm+zenoh");
    flows(&daemon, "demo", 0.25);
    flows(&daemon, "two", 0.5);
    // So it is with a reader, which connects again by itself.
    signal(&daemon, "second", "KILL");
    until("the reader is back", || {
        let all = daemon.json(&["connections"]);
        let all = all["connections"].as_array().unwrap();
        all.iter().any(|one| one["in"] == "two/parameter" && one["backend"] == "zenoh")
    });
    flows(&daemon, "two", 0.75);
    disconnect(&daemon, "demo");
    disconnect(&daemon, "two");
    until("the end is closed", || writer_is_on(&daemon) == "shm");
}

#[test]
fn readers_and_cells_that_go_for_good_need_no_end_any_more() {
    let daemon = placed(&["--cell", "first"], &[]);
    connect(&daemon, "demo", "zenoh");
    connect(&daemon, "two", "zenoh");
    daemon.ctl(&["unload", "demo"]).expect_code(0);
    flows(&daemon, "two", 0.25);
    assert_eq!(writer_is_on(&daemon), "shm+zenoh");
    daemon.ctl(&["unload", "two"]).expect_code(0);
    until("the end is closed", || writer_is_on(&daemon) == "shm");
}

#[test]
fn a_deployment_in_cells_says_over_what_a_connection_goes() {
    let (demo, paper) = (component("demo"), component("demo-2010"));
    let deployment = |over: &str| {
        format!(
            "[[component]]\nlibrary = {:?}\ncell = \"second\"\nname = \"two\"\n\
             [[component]]\nlibrary = {:?}\nname = \"paper\"\ncell = \"first\"\n\
             [[component]]\nlibrary = {:?}\n\
             [[connection]]\nin = \"two/parameter\"\nout = \"paper/position\"\n{over}\
             [[connection]]\nin = \"demo/parameter\"\nout = \"paper/position\"\n{over}",
            demo.library, paper.description, demo.library
        )
    };
    let home = Home::new().configured(&deployment("over = \"zenoh\"\n"));
    let daemon = home.start(&["--backend", "local"]);
    until("all is connected", || {
        let all = daemon.json(&["connections"]);
        all["connections"].as_array().unwrap().len() == 2
    });
    flows(&daemon, "two", 0.25);
    flows(&daemon, "demo", 0.5);
    assert_eq!(writer_is_on(&daemon), "shm+zenoh");
    let file = daemon.home().path().join("next.toml");
    let apply = |text: &str| {
        std::fs::write(&file, text).unwrap();
        daemon.ctl(&["apply", path(&file)]).expect_code(0);
    };
    apply(&deployment(""));
    until("the end is closed", || writer_is_on(&daemon) == "shm");
    flows(&daemon, "demo", 0.75);
    apply(&deployment("over = \"zenoh\"\n"));
    assert_eq!(writer_is_on(&daemon), "shm+zenoh");
    flows(&daemon, "two", 0.875);
}
