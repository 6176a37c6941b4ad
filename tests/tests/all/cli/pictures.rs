//! Plots and drawings of what runs.

use genom_tests::{Daemon, component, path, until};
use serde_json::{Value, json};

/// A daemon whose clock stands still until it is stepped, with a plot of the demo's position that
/// has begun.
fn plotted(more: &[&str]) -> (Daemon, genom_tests::Running) {
    let daemon = Daemon::start(&["--clock", "virtual", path(&component("demo").library)]);
    let plot = ["plot", "demo/position", "--span", "3600", "--once"];
    let running = daemon.spawn(&[more, &plot].concat());
    assert!(running.error_line_where(|line| line.contains("plotting for 3600 s")).is_some());
    (daemon, running)
}

#[test]
fn a_plot_has_every_sample_of_the_numbers_of_a_port() {
    let (daemon, running) = plotted(&["--json"]);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    daemon.ctl(&["step", "4s"]).expect_code(0);
    assert_eq!(daemon.port("demo", "position")["value"]["position"], 1.0);
    // The axis has written in every period of its motion.
    let traffic = daemon.json(&["hz", "demo/position", "--total"]);
    running.signal("INT");
    let finished = running.finish();
    finished.expect_code(0);
    let data: Value = serde_json::from_str(&finished.out).unwrap();
    let curves = data["curves"].as_array().unwrap();
    let names: Vec<_> = curves.iter().map(|curve| curve["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["demo/position.position", "demo/position.velocity"]);
    // One was written before the plot began.
    let written = traffic["samples"].as_u64().unwrap() - 1;
    assert!(curves.iter().all(|curve| curve["samples"] == written), "{written}: {data}");
    let most = |curve: &Value| {
        let points = curve["points"].as_array().unwrap().iter();
        points.map(|point| point[2].as_f64().unwrap()).fold(0.0, f64::max)
    };
    assert_eq!((most(&curves[0]), most(&curves[1])), (1.0, 0.5));
    assert_eq!(data["lost"], 0);
}

#[test]
fn without_a_terminal_the_last_picture_is_printed() {
    let (daemon, running) = plotted(&[]);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    daemon.ctl(&["step", "10s"]).expect_code(0);
    running.signal("INT");
    let finished = running.finish();
    finished.expect_code(0);
    for text in ["-3600 s", "━ demo/position.position = 1  ", "━ demo/position.velocity = 0  "]
    {
        assert!(finished.out.contains(text), "{}", finished.out);
    }
    assert!(finished.out.chars().any(|c| ('\u{2801}'..='\u{28ff}').contains(&c)), "dots");
    assert!(!finished.out.contains('\u{1b}'), "plain text");
}

#[test]
fn on_a_terminal_a_plot_is_live_until_q() {
    let daemon = Daemon::demo("local");
    let steps = json!([{"wait": "demo/position.velocity"}, {"wait": "samples"}, {"type": "q"}]);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    daemon.on_terminal(100, &[], &steps, &["plot", "demo/position.velocity"]).expect_code(0);
}

#[test]
fn what_runs_is_drawn_with_cells_connections_and_rates() {
    let (demo, rust) = (component("demo"), component("demo-rs"));
    let daemon = Daemon::start(&["--backend", "shm", path(&demo.library)]);
    daemon.ctl(&["load", "--name", "arm", "--cell", "right", path(&rust.library)]).expect_code(0);
    daemon.ctl(&["connect", "--wait", "demo/parameter", "elsewhere/gain"]).expect_code(0);
    daemon.ctl(&["connect", "--wait", "arm/parameter", "elsewhere/gain"]).expect_code(0);
    let drawn = daemon.ctl(&["graph", "--format", "svg", "--window", "0"]);
    drawn.expect_code(0);
    let document = roxmltree::Document::parse(&drawn.out).expect("well-formed");
    let texts: Vec<_> = document
        .descendants()
        .filter(|node| node.has_tag_name(("http://www.w3.org/2000/svg", "text")))
        .filter_map(|node| node.text())
        .collect();
    for text in ["demo", "arm", "elsewhere", "cell right", "position", "parameter", "gain", "shm"] {
        assert!(texts.contains(&text), "{text}: {texts:?}");
    }
    let edges = document.descendants().filter(|node| node.attribute("marker-end").is_some());
    assert_eq!(edges.count(), 2);
    let drawn = daemon.ctl(&["graph", "--format", "mermaid", "--window", "0"]);
    assert!(drawn.out.contains("subgraph g1[\"cell right\"]"), "{}", drawn.out);
    // The axis reads its gain in each period, and has a rate when there are new ones.
    daemon.ctl(&["disconnect", "demo/parameter"]).expect_code(0);
    daemon.ctl(&["call", "demo", "set_speed", "velocity=0.01"]).expect_code(0);
    daemon.ctl(&["start", "demo", "goto", "goal=1"]).expect_code(0);
    until("a rate is drawn", || {
        let drawing = daemon.spawn(&["graph", "--window", "1"]);
        for number in 0..10 {
            daemon.ctl(&["pub", "demo/parameter", &format!("0.{number}")]).expect_code(0);
        }
        drawing.finish().out.contains("parameter, ")
    });
}
