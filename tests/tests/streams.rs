//! Streams and limits of the control plane.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::unwrap_used, reason = "helpers of tests fail them")]

use std::fs;
use std::io::{BufReader, Write as _};

use genom_tests::{Daemon, Home, component, connect, path, request};

/// Reads a stream up to the first event that holds `text`; the lines so far.
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

#[test]
fn one_activity_too_many_is_told_so() {
    let blocks = component("blocks");
    let daemon = Daemon::start(&[path(&blocks.library)]);
    let socket = daemon.home().socket();
    let mut last = (0, String::new());
    // The task runs 16 at a time: the codel of the first never returns.
    for _ in 0..17 {
        let reply = request(&socket, "POST", "/components/blocks/services/hang", "");
        last = (reply.status, reply.code().to_owned());
    }
    assert_eq!(last, (429, "too_many_activities".to_owned()));
    let mut events = daemon.events();
    daemon.process().signal("TERM");
    events.wait_for(|e| e["event"] == "stopping");
    let _ = daemon.stop("TERM");
}

#[test]
fn logs_are_kept_and_followed_by_component_and_level() {
    let daemon = Daemon::demo("local");
    let following = daemon.spawn(&["logs", "--follow"]);
    // What is kept comes first, then what happens.
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
