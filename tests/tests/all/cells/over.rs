//! Connections between processes of a daemon over a middleware that is asked for.

use genom_tests::{Daemon, Home, component, path, request, until};
use serde_json::json;

use super::{cell, load, signal};

/// The writer, the paper's component, and two readers, each in the daemon's process or in a cell.
fn placed(paper: &[&str], demo: &[&str]) -> Daemon {
    configured("[cells]\nrestart_delay = 0.0\n", paper, demo)
}

fn configured(cells: &str, paper: &[&str], demo: &[&str]) -> Daemon {
    let daemon = Home::new().configured(cells).start(&["--backend", "local"]);
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
            .expect_err("paper/position is read in another process, and local does not leave one");
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

#[test]
fn a_writer_that_comes_back_in_another_process_is_read_over_the_same_middleware() {
    let daemon = placed(&["--cell", "first"], &[]);
    connect(&daemon, "demo", "zenoh");
    connect(&daemon, "two", "zenoh");
    let description = component("demo-2010").description;
    let load = ["load", path(&description), "--name", "paper"];
    let places: [(&[&str], &str); 3] =
        [(&[], "local"), (&["--cell", "second"], "shm"), (&["--cell", "third"], "shm")];
    for (round, (place, own)) in (0_u32..).zip(places) {
        daemon.ctl(&["unload", "paper"]).expect_code(0);
        daemon.ctl(&[&load[..], place].concat()).expect_code(0);
        until("the end is open", || writer_is_on(&daemon) == format!("{own}+zenoh"));
        flows(&daemon, "demo", 0.5 + f64::from(round) / 8.0);
        flows(&daemon, "two", 0.25 + f64::from(round) / 16.0);
    }
    disconnect(&daemon, "demo");
    disconnect(&daemon, "two");
    until("the end is closed", || writer_is_on(&daemon) == "shm");
}

#[test]
fn a_connection_may_be_made_before_its_writer_is_loaded_in_another_process() {
    let daemon = placed(&["--cell", "first"], &[]);
    for reader in ["demo", "two"] {
        let inport = format!("{reader}/parameter");
        let connect = ["connect", &inport, "late/position", "--over", "zenoh", "--wait"];
        daemon.ctl(&connect).expect_code(0);
    }
    let description = component("demo-2010").description;
    let load = ["load", path(&description), "--name", "late", "--cell", "third"];
    daemon.ctl(&load).expect_code(0);
    until("the end is open", || daemon.port("late", "position")["backend"] == "shm+zenoh");
    disconnect(&daemon, "demo");
    disconnect(&daemon, "two");
    until("the end is closed", || daemon.port("late", "position")["backend"] == "shm");
}

#[test]
fn a_new_daemon_goes_on_with_connections_between_the_cells_that_it_takes_over() {
    let daemon = placed(&["--cell", "first"], &["--cell", "third"]);
    connect(&daemon, "demo", "zenoh");
    connect(&daemon, "two", "zenoh");
    let home = daemon.abandon();
    let daemon = home.start(&["--backend", "local"]);
    assert_eq!(writer_is_on(&daemon), "shm+zenoh");
    flows(&daemon, "two", 0.25);
    // It tells a new process of the writer what the daemon before did.
    signal(&daemon, "first", "KILL");
    until("the end is open again", || writer_is_on(&daemon) == "shm+zenoh");
    flows(&daemon, "demo", 0.5);
    disconnect(&daemon, "two");
    flows(&daemon, "demo", 0.75);
    disconnect(&daemon, "demo");
    until("the end is closed", || writer_is_on(&daemon) == "shm");
}

#[test]
fn an_end_that_only_a_daemon_before_this_one_needed_is_closed() {
    let daemon = placed(&["--cell", "first"], &[]);
    connect(&daemon, "demo", "zenoh");
    let home = daemon.abandon();
    let daemon = home.start(&["--backend", "local"]);
    until("the end is closed", || writer_is_on(&daemon) == "shm");
}

#[test]
fn a_deployment_that_fails_leaves_connections_over_the_middleware_they_were_on() {
    let daemon = placed(&["--cell", "first"], &[]);
    connect(&daemon, "demo", "zenoh");
    connect(&daemon, "two", "zenoh");
    let connections = || {
        let all = daemon.json(&["connections"]);
        let all = all["connections"].as_array().unwrap().iter();
        let mut all: Vec<_> =
            all.map(|one| (one["in"].to_string(), one["backend"].to_string())).collect();
        all.sort();
        all
    };
    let was = connections();
    let (demo, paper) = (component("demo"), component("demo-2010"));
    let fault = "[[call]]\ncomponent = \"two\"\nservice = \"goto\"\ninputs = { goal = 99.0 }\n";
    let deployment = |fault: &str| {
        format!(
            "[[component]]\nlibrary = {:?}\ncell = \"second\"\nname = \"two\"\n\
             [[component]]\nlibrary = {:?}\nname = \"paper\"\ncell = \"first\"\n\
             [[component]]\nlibrary = {:?}\n\
             [[connection]]\nin = \"two/parameter\"\nout = \"paper/position\"\nover = \"ros2\"\n\
             [[connection]]\nin = \"demo/parameter\"\nout = \"paper/position\"\nover = \"ros2\"\n\
             {fault}",
            demo.library, paper.description, demo.library
        )
    };
    let file = daemon.home().path().join("next.toml");
    std::fs::write(&file, deployment(fault)).unwrap();
    let refused = daemon.ctl(&["apply", path(&file)]);
    refused.expect_code(1).expect_err("OUT_OF_RANGE").expect_err("everything is as it was before");
    assert_eq!((connections(), &*writer_is_on(&daemon)), (was.clone(), "shm+zenoh"));
    flows(&daemon, "demo", 0.25);
    flows(&daemon, "two", 0.5);
    // Nor does one that is undone later.
    std::fs::write(&file, deployment("")).unwrap();
    daemon.ctl(&["apply", path(&file)]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "shm+ros2");
    let back = request(&daemon.home().socket(), "POST", "/deployment/take_back", "");
    assert_eq!((back.status, back.body), (200, json!({ "left": [] })));
    assert_eq!((connections(), &*writer_is_on(&daemon)), (was, "shm+zenoh"));
    flows(&daemon, "demo", 0.75);
    flows(&daemon, "two", 0.875);
}

#[test]
fn a_cell_that_does_not_answer_keeps_no_other_connection_waiting() {
    // It is not killed meanwhile.
    let daemon = configured("[cells]\nalive_timeout = 300.0\n", &["--cell", "first"], &[]);
    load(&daemon, "demo", &["--name", "third", "--cell", "third"]);
    let description = component("demo-2010").description;
    daemon.ctl(&["load", path(&description), "--name", "other", "--cell", "fourth"]).expect_code(0);
    let pid = cell(&daemon, "first")["pid"].clone();
    assert!(genom_tests::signal(&pid, "STOP"));
    let waits = daemon.spawn(&["connect", "demo/parameter", "paper/position", "--over", "zenoh"]);
    let connect = ["connect", "third/parameter", "other/position", "--over", "zenoh"];
    daemon.ctl(&connect).expect_code(0);
    disconnect(&daemon, "third");
    daemon.ctl(&["connect", "two/parameter", "other/position"]).expect_code(0);
    assert!(genom_tests::signal(&pid, "CONT"));
    waits.finish().expect_code(0);
    assert_eq!(writer_is_on(&daemon), "shm+zenoh");
}

#[test]
fn what_another_program_tells_a_cell_lasts_until_the_daemon_tells_it_again() {
    let daemon = placed(&["--cell", "first"], &[]);
    connect(&daemon, "demo", "zenoh");
    let socket = daemon.home().socket();
    let put = |body: &str| request(&socket, "PUT", "/components/paper/ends", body).status;
    assert_eq!(put(r#"{"ports":{}}"#), 200);
    until("the end is open again", || writer_is_on(&daemon) == "shm+zenoh");
    flows(&daemon, "demo", 0.25);
}
