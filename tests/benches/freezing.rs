//! How long it takes to freeze 1, 50 and 500 components and to thaw them in another daemon, and how
//! large the file is: in the process of the daemon, and in ten cells.
//!
//! `cargo bench -p genom-tests --bench freezing [-- NUMBER...]`. The components are chained: each reads
//! two ports of the one before. Each number is tried five times; medians and greatest. The programs
//! are built with `--release`, as users build them.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark")]

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use genom_tests::{Footprint, Home, Many, Running, release, request};
use serde_json::Value;

/// How often each is tried.
const TIMES: usize = 5;
/// Number of cells.
const CELLS: usize = 10;

fn main() {
    let numbers: Vec<usize> = std::env::args().filter_map(|word| word.parse().ok()).collect();
    let numbers = if numbers.is_empty() { vec![1, 50, 500] } else { numbers };
    let genomd = release();
    println!(
        "{:>10} {:>10} {:>20} {:>20} {:>20} {:>12} {:>12}",
        "components",
        "in",
        "file",
        "freeze, median/most",
        "thaw, median/most",
        "MB before",
        "MB after"
    );
    for components in numbers {
        for cells in [0, CELLS] {
            measure(&genomd, components, cells);
        }
    }
}

fn measure(genomd: &Path, components: usize, cells: usize) {
    let made = tempfile::tempdir().expect("a directory");
    let text = Many { components, chained: true, cells }.configuration("shm", made.path());
    let (home, daemon) = start(genomd, &text);
    let mut freezes = Vec::new();
    let mut frozen = Value::Null;
    for _ in 0..TIMES {
        let begin = Instant::now();
        let reply = request(&home.socket(), "POST", "/freeze", "");
        freezes.push(begin.elapsed());
        assert_eq!(reply.status, 200, "{}", reply.body);
        frozen = reply.body;
    }
    let before = resident(&home, &daemon);
    end(daemon);
    assert_eq!(frozen["components"].as_object().map(serde_json::Map::len), Some(components));
    let (mut thaws, mut after) = (Vec::new(), 0.0);
    for _ in 0..TIMES {
        let (home, daemon) = start(genomd, "backend = \"shm\"\n");
        let wanted = serde_json::json!({ "frozen": frozen }).to_string();
        let begin = Instant::now();
        let reply = request(&home.socket(), "POST", "/thaw", &wanted);
        thaws.push(begin.elapsed());
        assert_eq!(reply.status, 200, "{}", reply.body);
        let thawed = reply.body["components"].as_array().expect("a list").len();
        assert_eq!(thawed, components);
        after = resident(&home, &daemon);
        end(daemon);
    }
    let file: genom_protocol::Frozen = serde_json::from_value(frozen).expect("what is frozen");
    let file = file.text().len();
    println!(
        "{components:>10} {:>10} {:>20} {:>20} {:>20} {before:>12.1} {after:>12.1}",
        if cells == 0 { "the daemon".to_owned() } else { format!("{cells} cells") },
        format!("{file} ({} each)", file / components),
        told(freezes),
        told(thaws),
    );
}

fn start(genomd: &Path, text: &str) -> (Home, Running) {
    let home = Home::new().configured(text);
    let mut command = Command::new(genomd);
    command.arg("--config").arg(home.path().join("genomd.toml"));
    command.arg("--socket").arg(home.socket());
    let daemon = Running::start(&mut command);
    let ready = daemon.error_line_where(|line| line.contains("ready on "));
    assert!(ready.is_some(), "it starts");
    let ready = request(&home.socket(), "GET", "/ready?wait=60&deployed=true", "").body;
    assert_eq!(ready["ready"], true, "all is there: {ready}");
    (home, daemon)
}

fn end(daemon: Running) {
    daemon.signal("TERM");
    let ended = daemon.finish_within(Duration::from_secs(120));
    assert_eq!(ended.code, Some(0), "{}", ended.err);
}

/// Of the daemon and its cells, in MB.
fn resident(home: &Home, daemon: &Running) -> f64 {
    let cells = request(&home.socket(), "GET", "/cells", "").body;
    let cells = cells["cells"].as_array().into_iter().flatten();
    let pids = cells.filter_map(|cell| u32::try_from(cell["pid"].as_u64()?).ok());
    let all: Vec<u32> = std::iter::once(daemon.id()).chain(pids).collect();
    Footprint::of_all(&all).resident as f64 / 1024.0
}

fn told(mut times: Vec<Duration>) -> String {
    times.sort_unstable();
    let ms = |time: Option<&Duration>| time.map_or(0.0, |time| time.as_secs_f64() * 1e3);
    format!("{:.1}/{:.1} ms", ms(times.get(times.len() / 2)), ms(times.last()))
}
