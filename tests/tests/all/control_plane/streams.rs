//! Streams and limits of the control plane.

use std::fs;
use std::io::{BufReader, Write as _};

use genom_tests::{Daemon, Home, component, connect, path, request};

/// Reads a stream up to the first event that contains `text`; returns the lines.
fn read_until(reader: &mut impl std::io::BufRead, text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    loop {
        let mut line = String::new();
        assert!(reader.read_line(&mut line).unwrap() > 0, "the stream ended: {lines:#?}");
        lines.push(line.trim_end().to_owned());
        if line.contains(text) {
            return lines;
        }
    }
}

#[test]
fn a_listener_that_comes_back_hears_what_it_missed() {
    let daemon = Daemon::demo("local");
    daemon.ctl(&["call", "demo", "goto", "goal=0.01"]).expect_code(0);
    let mut stream = connect(&daemon.home().socket());
    write!(stream, "GET /events HTTP/1.1\r\nHost: x\r\nLast-Event-ID: 1\r\n\r\n").unwrap();
    let mut reader = BufReader::new(stream);
    let heard = read_until(&mut reader, "activity_ended");
    assert!(!heard.iter().any(|line| line == "id: 1"), "{heard:#?}");
    assert!(heard.iter().any(|line| line == "id: 2"), "{heard:#?}");
    assert!(heard.iter().any(|line| line.contains("activity_started")), "{heard:#?}");
}

/// Fires an event this many times on one connection.
fn fire(daemon: &Daemon, times: usize) {
    /// Requests in progress at a time; their replies fit into the socket's buffer.
    const TURN: usize = 100;
    let mut stream = connect(&daemon.home().socket());
    let mut answers = BufReader::new(stream.try_clone().unwrap());
    for begin in (0..times).step_by(TURN) {
        let turn = TURN.min(times - begin);
        let one = "POST /components/demo/events/emergency HTTP/1.1\r\nHost: x\r\n\r\n";
        stream.write_all(one.repeat(turn).as_bytes()).unwrap();
        for _ in 0..turn {
            read_until(&mut answers, "HTTP/1.1 200");
        }
    }
}

#[test]
fn a_listener_that_was_away_for_long_hears_how_much_it_missed() {
    let daemon = Daemon::start(&["--clock", "virtual", path(&component("demo").library)]);
    fire(&daemon, 1500);
    let mut stream = connect(&daemon.home().socket());
    write!(stream, "GET /events HTTP/1.1\r\nHost: x\r\nLast-Event-ID: 1\r\n\r\n").unwrap();
    let mut reader = BufReader::new(stream);
    let heard = read_until(&mut reader, "data: ");
    // All but the first and the 1024 that are kept. Before the first was fired there was one event:
    // that the component runs.
    assert_eq!(heard.last().unwrap(), r#"data: {"event":"missed","changes":476}"#, "{heard:#?}");
    assert!(heard.contains(&"id: 477".to_owned()), "{heard:#?}");
    let next = read_until(&mut reader, "data: ");
    assert!(next.contains(&"id: 478".to_owned()), "{next:#?}");
    assert!(next.last().unwrap().contains("event_fired"), "{next:#?}");
}

#[test]
fn a_follower_that_stood_still_tells_how_many_events_it_missed() {
    let daemon = Daemon::start(&["--clock", "virtual", path(&component("demo").library)]);
    let events = daemon.spawn(&["--json", "events"]);
    let (sender, first) = std::sync::mpsc::channel();
    let events = std::thread::scope(|scope| {
        scope.spawn(move || {
            events.line();
            sender.send(events).unwrap();
        });
        // One of them is fired after it has begun to listen.
        loop {
            fire(&daemon, 1);
            if let Ok(events) = first.try_recv() {
                break events;
            }
        }
    });
    let library = component("demo").library;
    daemon.ctl(&["load", path(&library), "--name", "mark"]).expect_code(0);
    events.line_where(|line| line.contains("component_loaded"));
    // It is stopped, and more happens than it, the socket and the daemon can buffer.
    events.signal("STOP");
    while !stands_still(events.id()) {}
    let times = 12_000;
    fire(&daemon, times);
    daemon.ctl(&["unload", "mark"]).expect_code(0);
    events.signal("CONT");
    let (mut told, mut missed) = (0, 0);
    loop {
        let event: serde_json::Value = serde_json::from_str(&events.line()).unwrap();
        match event["event"].as_str() {
            Some("event_fired") => told += 1,
            Some("missed") => missed += event["changes"].as_u64().unwrap(),
            _ => break assert_eq!(event["event"], "component_unloaded"),
        }
    }
    assert!(missed > 0, "all were kept");
    assert_eq!(told + missed, times as u64);
}

/// Whether a process was stopped by a signal.
fn stands_still(id: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{id}/stat")).unwrap();
    stat.rsplit_once(") ").is_some_and(|(_, rest)| rest.starts_with('T'))
}

#[test]
fn more_streams_than_the_limit_are_refused() {
    let home = Home::new();
    fs::write(home.path().join("genomd.toml"), "[rpc]\nmax_streams = 2\n").unwrap();
    let daemon = home.start(&[]);
    let streams = [daemon.events(), daemon.events()];
    let refused = request(&daemon.home().socket(), "GET", "/events", "");
    assert_eq!((refused.status, refused.code()), (503, "too_many_streams"));
    daemon.ctl(&["list"]).expect_code(0);
    drop(streams);
}

#[test]
fn a_stream_that_nobody_reads_holds_up_nobody() {
    let daemon = Daemon::demo("local");
    let mut stream = connect(&daemon.home().socket());
    let path = "/components/demo/ports/position/stream?rate=1000";
    write!(stream, "GET {path} HTTP/1.1\r\nHost: x\r\n\r\n").unwrap();
    daemon.ctl(&["call", "demo", "goto", "goal=0.3"]).expect_code(0);
    let stats = daemon.json(&["stats", "demo"]);
    assert!(stats["tasks"][0]["cycles"]["count"].as_u64().unwrap() > 50, "{stats}");
}

#[test]
fn connections_beyond_the_limit_wait_for_their_turn() {
    let home = Home::new();
    fs::write(home.path().join("genomd.toml"), "[rpc]\nmax_connections = 2\n").unwrap();
    let daemon = home.start(&[]);
    let (one, two) = (connect(&daemon.home().socket()), connect(&daemon.home().socket()));
    let waiting = daemon.spawn(&["list"]);
    drop((one, two));
    waiting.finish().expect_code(0);
}

/// A task runs up to `most` activities at a time, and refuses the next.
#[track_caller]
fn there_is_room_for(most: usize, arguments: &[&str]) {
    let blocks = component("blocks");
    let daemon = Daemon::start(&[arguments, &[path(&blocks.library)]].concat());
    let socket = daemon.home().socket();
    // The codel of the first never returns.
    let start = || request(&socket, "POST", "/components/blocks/services/hang", "");
    assert!((0..most).all(|_| start().status == 202));
    let refused = start();
    assert_eq!((refused.status, refused.code()), (429, "too_many_activities"));
    let mut events = daemon.events();
    daemon.process().signal("TERM");
    events.wait_for(|e| e["event"] == "stopping");
    let _ = daemon.stop("TERM");
}

#[test]
fn one_activity_too_many_is_told_so() {
    there_is_room_for(16, &[]);
    there_is_room_for(40, &["--set", "max_activities=40"]);
    let refused = Home::new().refused(&["--set", "max_activities=0"]);
    refused.expect_code(2).expect_err("max_activities = 0: give 1 to 4096");
}

#[test]
fn logs_are_kept_and_followed_by_component_and_level() {
    let daemon = Daemon::demo("local");
    let following = daemon.spawn(&["logs", "--follow"]);
    // First the lines that are kept, then new ones.
    following.line_where(|line| line.ends_with("INFO  demo: runs on local"));
    following.line_where(|line| line.contains("ready on "));
    let library = component("demo").library;
    daemon.ctl(&["load", path(&library), "--name", "other"]).expect_code(0);
    following.line_where(|line| line.ends_with("INFO  other: runs on local"));
    daemon.ctl(&["unload", "other"]).expect_code(0);
    following.line_where(|line| line.ends_with("INFO  other: unloaded"));
    let of_other = daemon.json(&["logs", "other"]);
    let entries = of_other["logs"].as_array().unwrap();
    let messages: Vec<_> = entries.iter().map(|entry| entry["message"].as_str().unwrap()).collect();
    assert_eq!(messages, ["runs on local", "unloaded"]);
    assert_eq!(entries[0]["level"], "info");
    assert!(entries[0]["time"].as_f64() <= entries[1]["time"].as_f64());
    let last = daemon.json(&["logs", "-n", "1", "other"]);
    assert_eq!(last["logs"][0]["message"], "unloaded");
    assert_eq!(daemon.json(&["logs", "other", "--level", "warn"])["logs"], serde_json::json!([]));
}
