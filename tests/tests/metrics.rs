//! What a monitoring system reads.

#![forbid(unsafe_code)]
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::unwrap_used,
    reason = "helpers of tests fail them"
)]

use std::io::{Read as _, Write as _};

use genom_tests::{Daemon, component, connect, path};

fn metrics(daemon: &Daemon) -> String {
    let mut stream = connect(&daemon.home().socket());
    write!(stream, "GET /metrics HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n").unwrap();
    let mut reply = String::new();
    stream.read_to_string(&mut reply).unwrap();
    assert!(reply.starts_with("HTTP/1.1 200"), "{reply}");
    reply.split_once("\r\n\r\n").expect("a body").1.to_owned()
}

fn value(page: &str, sample: &str) -> f64 {
    let line = page.lines().find(|line| line.starts_with(sample));
    let line = line.unwrap_or_else(|| panic!("no {sample} in\n{page}"));
    line.rsplit_once(' ').expect("a value").1.parse().expect("a number")
}

#[test]
fn components_tasks_codels_ports_and_connections_are_counted() {
    let (demo, paper) = (component("demo"), component("demo-2010"));
    let daemon = Daemon::start(&["--backend", "shm", path(&demo.library)]);
    daemon.ctl(&["load", path(&paper.description), "--name", "paper"]).expect_code(0);
    daemon.ctl(&["connect", "demo/parameter", "paper/position"]).expect_code(0);
    daemon.ctl(&["call", "paper", "goto", "position=0.25"]).expect_code(0);
    daemon.ctl(&["call", "demo", "goto", "goal=0.02"]).expect_code(0);
    let page = metrics(&daemon);
    assert_eq!(value(&page, "genom_component{component=\"demo\",backend=\"shm\"}"), 1.0);
    assert_eq!(value(&page, "genom_activities{component=\"demo\"}"), 0.0);
    for sample in [
        "genom_task_work_seconds_count{component=\"demo\",task=\"main\"}",
        "genom_codel_seconds_count{component=\"demo\",owner=\"goto\"",
        "genom_port_samples_total{port=\"demo/position\"}",
        "genom_connection_samples_total{in=\"demo/parameter\",out=\"paper/position\",backend=\"shm\"}",
    ] {
        assert!(value(&page, sample) >= 1.0, "{sample}");
    }
    // Every sample belongs to a family that says what it is.
    let mut family = String::new();
    for line in page.lines() {
        match line.strip_prefix("# TYPE ") {
            Some(told) => family = told.split(' ').next().unwrap().to_owned(),
            None if line.starts_with('#') => {}
            None => assert!(line.starts_with(&family), "{line} in family {family}"),
        }
    }
}
