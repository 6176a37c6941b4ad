//! The metrics for monitoring systems.

use std::io::{Read as _, Write as _};
use std::process::Command;

use genom_components::python;
use genom_tests::{Daemon, Running, component, connect, path};

pub(crate) fn metrics(daemon: &Daemon) -> String {
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
    told_as_prometheus_reads(&page);
}

/// The checks of `promtool check metrics`, made with Prometheus' own parser for Python.
const CHECK: &str = r#"
import sys
from prometheus_client.parser import text_string_to_metric_families

names, seen = set(), set()
for family in text_string_to_metric_families(open(sys.argv[1]).read()):
    assert family.name not in names, f"{family.name} comes twice"
    names.add(family.name)
    assert family.documentation, f"{family.name} has no help"
    assert family.type in ("counter", "gauge", "summary"), f"{family.name}: {family.type}"
    assert family.samples, f"{family.name} is empty"
    for sample in family.samples:
        key = (sample.name, tuple(sorted(sample.labels.items())))
        assert key not in seen, f"{key} comes twice"
        seen.add(key)
        ends = {"counter": ["_total"], "summary": ["", "_sum", "_count"]}.get(family.type, [""])
        assert sample.name in [family.name + end for end in ends], sample.name
        assert not sample.name.endswith(("_ns", "_ms")), f"{sample.name}: base units"
        assert family.type == "gauge" or sample.value >= 0, f"{key}: {sample.value}"
print(len(names))
"#;

#[track_caller]
fn told_as_prometheus_reads(page: &str) {
    let python = python::environment(&["prometheus_client==0.22.1"])
        .unwrap_or_else(|error| panic!("{error}"));
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("metrics.txt");
    std::fs::write(&file, page).unwrap();
    let mut command = Command::new(python);
    command.env_clear().args(["-c", CHECK]).arg(file);
    let checked = Running::start(&mut command).finish();
    checked.expect_code(0);
    assert!(checked.out.trim().parse::<u32>().unwrap() >= 10, "{} families", checked.out);
}
