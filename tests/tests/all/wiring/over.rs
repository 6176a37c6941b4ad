//! Connections over a middleware that is asked for: the out port is on it as long as one of them
//! lasts.

use std::sync::Arc;

use genom_tests::{Daemon, Home, Memory, component, path, request, until};
use serde_json::Value;

/// A daemon whose components are on `local`, with a writer, `paper`, and two readers.
fn three(more: &[&str]) -> Daemon {
    let (demo, paper) = (component("demo"), component("demo-2010"));
    let daemon = Daemon::start(&["--backend", "local", path(&demo.library)]);
    let load = |file: &str, arguments: &[&str]| {
        daemon.ctl(&[&["load", file], arguments].concat()).expect_code(0);
    };
    load(path(&demo.library), &["--name", "two"]);
    load(path(&paper.description), &[&["--name", "paper"], more].concat());
    daemon
}

fn connect(daemon: &Daemon, reader: &str, over: &str) {
    let inport = format!("{reader}/parameter");
    let made = daemon.ctl(&["connect", &inport, "paper/position", "--over", over]);
    made.expect_code(0);
    made.expect_out(&format!("{inport} reads paper/position ({over}, latest)\n"));
}

/// The middlewares that the writer's port is on.
fn writer_is_on(daemon: &Daemon) -> String {
    daemon.port("paper", "position")["backend"].as_str().expect("a text").to_owned()
}

/// What a reader gets after the writer went to a position.
#[track_caller]
fn flows(daemon: &Daemon, reader: &str, position: f64) {
    daemon.ctl(&["call", "paper", "goto", &format!("position={position}")]).expect_code(0);
    until("the value arrives", || {
        daemon.ctl(&["call", reader, "goto", "goal=0.01"]).expect_code(0);
        daemon.ctl(&["call", reader, "goto", "goal=0"]).expect_code(0);
        daemon.port(reader, "parameter")["value"] == position
    });
}

/// Publishers of the writer's port that are visible on a middleware.
fn visible(daemon: &Daemon, over: &str) -> usize {
    let all = daemon.json(&["backends", "--visible"]);
    let mut all = all["middlewares"].as_array().unwrap().iter();
    let one = all.find(|one| one["name"] == over).expect("the middleware");
    let ends = one["endpoints"].as_array().into_iter().flatten();
    ends.filter(|end| end["kind"] == "publisher" && end["address"] == "paper/position").count()
}

#[test]
fn a_connection_over_a_middleware_opens_the_end_of_the_writer_and_closes_it_again() {
    let daemon = three(&[]);
    for (over, position) in [("shm", 0.25), ("zenoh", 0.5), ("ros2", 0.75)] {
        connect(&daemon, "demo", over);
        assert_eq!(writer_is_on(&daemon), format!("local+{over}"));
        // What the reader is on does not matter, and stays as it is.
        assert_eq!(daemon.port("demo", "parameter")["backend"], "local");
        flows(&daemon, "demo", position);
        let made = daemon.json(&["connections"])["connections"][0].clone();
        assert_eq!((&made["backend"], &made["fixed"]), (&over.into(), &true.into()));
        daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
        assert_eq!(writer_is_on(&daemon), "local");
        until("nobody sees it any more", || visible(&daemon, over) == 0);
    }
}

#[test]
fn an_end_stays_open_until_the_last_connection_over_it_is_gone() {
    let daemon = three(&[]);
    connect(&daemon, "demo", "shm");
    connect(&daemon, "two", "shm");
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "local+shm");
    flows(&daemon, "two", 0.25);
    daemon.ctl(&["disconnect", "two/parameter"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "local");
}

#[test]
fn a_connection_that_takes_another_middleware_leaves_the_one_before() {
    let daemon = three(&[]);
    for (over, on) in [("shm", "local+shm"), ("zenoh", "local+zenoh"), ("local", "local")] {
        connect(&daemon, "demo", over);
        assert_eq!(writer_is_on(&daemon), on);
    }
    connect(&daemon, "demo", "shm");
    daemon.ctl(&["connect", "demo/parameter", "paper/position"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "local", "none is asked for any more");
}

#[test]
fn a_reader_that_is_unloaded_needs_no_end_any_more() {
    let daemon = three(&[]);
    connect(&daemon, "two", "shm");
    daemon.ctl(&["unload", "two"]).expect_code(0);
    until("the end is closed", || writer_is_on(&daemon) == "local");
}

#[test]
fn a_writer_that_comes_back_is_read_over_the_same_middleware() {
    let daemon = three(&[]);
    connect(&daemon, "demo", "zenoh");
    daemon.ctl(&["unload", "paper"]).expect_code(0);
    let description = component("demo-2010").description;
    daemon.ctl(&["load", path(&description), "--name", "paper"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "local+zenoh");
    flows(&daemon, "demo", 0.25);
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "local");
}

#[test]
fn an_end_that_a_port_has_by_itself_stays_when_connections_over_it_go() {
    let daemon = three(&["--backend", "local+shm"]);
    connect(&daemon, "demo", "shm");
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "local+shm");
    // A move leaves what connections need.
    connect(&daemon, "demo", "shm");
    daemon.ctl(&["backend", "paper", "local"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "local+shm");
    flows(&daemon, "demo", 0.5);
    // And one that is needed may become the port's own.
    daemon.ctl(&["backend", "paper/position", "shm"]).expect_code(0);
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "shm");
}

#[test]
fn what_is_refused_leaves_no_end_open_and_the_connection_before() {
    let daemon = three(&[]);
    connect(&daemon, "demo", "zenoh");
    let over = |more: &[&str]| {
        let connect = ["connect", "demo/parameter"];
        let refused = daemon.ctl(&[&connect, more].concat());
        refused.expect_code(1);
        assert_eq!(writer_is_on(&daemon), "local+zenoh", "{more:?}");
        let made = daemon.json(&["connections"])["connections"].clone();
        assert_eq!((made.as_array().unwrap().len(), &made[0]["backend"]), (1, &"zenoh".into()));
        refused
    };
    over(&["paper/position", "--over", "zeno"]).expect_err("did you mean `zenoh`?");
    over(&["two/position", "--over", "shm"]).expect_err("demo::state");
    over(&["paper/nothing", "--over", "shm"]).expect_err("paper has no port `nothing`");
    over(&["ros2:paper/position", "--over", "shm"]).expect_err("name one of the two");
    // The end of the writer is open by then, and the reader's cannot be had.
    over(&["paper/position", "--over", "shm", "--policy", "queue:60000"])
        .expect_err("at most 16 unread samples");
    flows(&daemon, "demo", 0.5);
}

#[test]
fn a_reader_of_another_daemon_is_told_the_command_that_opens_the_port_there() {
    let memory = Arc::new(Memory::new());
    let (paper, demo) = (component("demo-2010"), component("demo"));
    let writer = ["--backend", "shm", "--name", "paper", path(&paper.description)];
    let writer = Home::with(&memory).start(&writer);
    let reader = Home::with(&memory).start(&["--backend", "shm", path(&demo.library)]);
    let over = ["connect", "demo/parameter", "paper/position", "--over", "zenoh"];
    let refused = reader.ctl(&over);
    refused.expect_code(1).expect_err("paper/position is on shm, not on zenoh");
    let command = ["backend", "paper/position", "shm+zenoh"];
    refused.expect_err(&format!("`genomctl {}` there", command.join(" ")));
    writer.ctl(&command).expect_code(0);
    reader.ctl(&over).expect_code(0);
}

#[test]
fn a_deployment_says_over_what_a_connection_goes_and_the_dump_says_it_again() {
    let (demo, paper) = (component("demo"), component("demo-2010"));
    let deployment = |over: &str| {
        format!(
            "[[component]]\nlibrary = {:?}\n[[component]]\nlibrary = {:?}\nname = \"paper\"\n\
             [[connection]]\nin = \"demo/parameter\"\nout = \"paper/position\"\n{over}",
            demo.library, paper.description
        )
    };
    let home = Home::new().configured(&deployment("over = \"shm\"\n"));
    let daemon = home.start(&["--backend", "local"]);
    let on = |wanted: &str| until(wanted, || writer_is_on(&daemon) == wanted);
    on("local+shm");
    let dump = daemon.ctl(&["dump"]).out;
    assert!(dump.contains("over = \"shm\"") && !dump.contains("ports"), "{dump}");
    let file = daemon.home().path().join("next.toml");
    let apply = |text: &str| {
        std::fs::write(&file, text).unwrap();
        let applied = daemon.json(&["apply", path(&file)]);
        applied["steps"].as_array().unwrap().len()
    };
    assert_eq!(apply(&dump), 0, "it is so already");
    // `backend` is what the key was called before.
    assert_eq!(apply(&deployment("backend = \"zenoh\"\n")), 1);
    on("local+zenoh");
    assert_eq!(apply(&deployment("")), 1);
    on("local");
}

/// Descriptors that a process has open.
fn descriptors(daemon: &Daemon) -> usize {
    let pid = daemon.process().id();
    std::fs::read_dir(format!("/proc/{pid}/fd")).unwrap().count()
}

#[test]
fn descriptors_and_ends_are_what_they_were_after_many_connections_over_a_middleware() {
    let daemon = three(&[]);
    let names: Vec<String> = (0..8).map(|one| format!("reader{one}")).collect();
    let library = component("demo").library;
    for name in &names {
        daemon.ctl(&["load", path(&library), "--name", name]).expect_code(0);
    }
    for over in ["shm", "zenoh"] {
        // The middleware itself stays open once it was used.
        connect(&daemon, "demo", over);
        daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
        let before = descriptors(&daemon);
        names.iter().for_each(|name| connect(&daemon, name, over));
        assert_eq!(writer_is_on(&daemon), format!("local+{over}"));
        for name in &names {
            daemon.ctl(&["disconnect", &format!("{name}/parameter")]).expect_code(0);
        }
        assert_eq!(writer_is_on(&daemon), "local");
        until("all is closed", || descriptors(&daemon) <= before && visible(&daemon, over) == 0);
    }
}

#[test]
fn what_processes_need_of_each_other_is_checked_as_any_request() {
    let daemon = three(&[]);
    let put = |component: &str, body: &str| -> (u16, Value) {
        let at = format!("/components/{component}/ends");
        let reply = request(&daemon.home().socket(), "PUT", &at, body);
        (reply.status, reply.body)
    };
    let many: Vec<String> = (0..5000).map(|one| format!("\"position/{one}\":\"shm\"")).collect();
    for (component, body, status, says) in [
        ("nobody", r#"{"ports":{}}"#, 404, "nobody"),
        ("paper", r#"{"ports":{"positon":"shm"}}"#, 404, "position"),
        ("paper", r#"{"ports":{"position":"shn"}}"#, 422, "shn"),
        ("paper", r#"{"ports":{"position":["shm","shn"]}}"#, 422, "shn"),
        ("paper", r#"{"ports":{"position":[]}}"#, 422, "one backend at least"),
        ("paper", r#"{"port":{}}"#, 422, "port"),
        ("paper", &format!("{{\"ports\":{{{}}}}}", many.join(",")), 422, "4096"),
    ] {
        let (got, reply) = put(component, body);
        assert_eq!(got, status, "{reply}");
        assert!(reply.to_string().contains(says), "{reply}");
        assert_eq!(writer_is_on(&daemon), "local");
    }
    // What is no element of the port, or not open, waits until it is.
    assert_eq!(put("paper", r#"{"ports":{"position/a":"shm"}}"#).0, 200);
    assert_eq!(writer_is_on(&daemon), "local");
    assert_eq!(put("paper", r#"{"ports":{"position":"shm"}}"#).0, 200);
    assert_eq!(writer_is_on(&daemon), "local+shm");
    // A connection of this process over the same keeps it when the others need it no more.
    connect(&daemon, "demo", "shm");
    assert_eq!(put("paper", r#"{"ports":{}}"#).0, 200);
    assert_eq!(writer_is_on(&daemon), "local+shm");
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    assert_eq!(writer_is_on(&daemon), "local");
}
