//! Cost of many components: 1, 50 and 500 with five ports each, on local and shared memory.
//! Measures the time until ready, stop, memory, file descriptors, processor time while nobody asks
//! for anything, and the duration of `list` and `ports`; with a thread for each task, with one for all
//! (`execution`), and in ten cells. Figures of several processes are sums.
//!
//! `cargo bench -p genom-tests --bench many [-- BACKEND... WAY... NUMBER...]`. The programs are built with
//! `--release`, as users build them.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark")]

use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use genom_tests::{Footprint, Home, Many, Running, processor_time, release, request};

/// Number of requests of each kind.
const REQUESTS: usize = 200;
/// For how long the processor time is measured.
const IDLE: Duration = Duration::from_secs(5);
/// Ways to execute components: in the process of the daemon, or in cells with a thread for each task.
const WAYS: [&str; 3] = ["threads", "single", "cells"];
/// Number of cells.
const CELLS: usize = 10;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let numbers: Vec<usize> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let numbers = if numbers.is_empty() { vec![1, 50, 500] } else { numbers };
    let names =
        || words.iter().map(String::as_str).filter(|word: &&str| word.parse::<usize>().is_err());
    let (ways, backends): (Vec<&str>, Vec<&str>) = names().partition(|name| WAYS.contains(name));
    let ways = if ways.is_empty() { WAYS.to_vec() } else { ways };
    let backends = if backends.is_empty() { vec!["local", "shm"] } else { backends };
    let genomd = release();
    println!(
        "{:8} {:8} {:>6} {:>9} {:>9} {:>9} {:>8} {:>8} {:>8} {:>7} {:>17} {:>17}",
        "backend",
        "",
        "number",
        "start",
        "stop",
        "MB",
        "shm MB",
        "files",
        "threads",
        "cpu",
        "list p50/p99",
        "ports p50/p99"
    );
    for backend in backends {
        for &components in &numbers {
            ways.iter().for_each(|way| measure(&genomd, backend, way, components));
        }
    }
}

fn measure(genomd: &PathBuf, backend: &str, way: &str, components: usize) {
    let made = tempfile::tempdir().expect("a directory");
    let cells = if way == "cells" { CELLS } else { 0 };
    let text = Many { components, chained: false, cells }.configuration(backend, made.path());
    let home = Home::new().configured(&text);
    let mut command = Command::new(genomd);
    command.arg("--config").arg(home.path().join("genomd.toml"));
    command.arg("--socket").arg(home.socket());
    if way != "cells" {
        command.args(["--execution", way]);
    }
    let begin = Instant::now();
    let daemon = Running::start(&mut command);
    let ready = daemon.error_line_where(|line| line.contains("ready on "));
    if ready.is_none() {
        let said = daemon.finish().err;
        println!(
            "{backend:8} {way:8} {components:>6} refused: {}",
            said.lines().last().unwrap_or("")
        );
        return;
    }
    if cells > 0 {
        let ready = request(&home.socket(), "GET", "/ready?wait=60&deployed=true", "").body;
        assert_eq!(ready["ready"], true, "all cells run");
    }
    let start = begin.elapsed();
    let processes = processes(&home, daemon.id());
    let time = || processes.iter().map(|&process| processor_time(process)).sum::<Duration>();
    let held = Footprint::of_all(&processes);
    let (at, before) = (Instant::now(), time());
    while at.elapsed() < IDLE {
        std::thread::park_timeout(IDLE.saturating_sub(at.elapsed()));
    }
    let used = time().saturating_sub(before);
    let used = used.as_secs_f64() / at.elapsed().as_secs_f64() * 100.0;
    let answered = |path: &str| {
        let mut all: Vec<Duration> = (0..REQUESTS)
            .map(|_| {
                let begin = Instant::now();
                assert_eq!(request(&home.socket(), "GET", path, "").status, 200);
                begin.elapsed()
            })
            .collect();
        all.sort_unstable();
        let at = |part: usize| all[(all.len() - 1) * part / 100].as_secs_f64() * 1e3;
        format!("{:.1}/{:.1} ms", at(50), at(99))
    };
    let (list, ports) = (answered("/components"), answered("/ports?values=false"));
    let begin = Instant::now();
    daemon.signal("TERM");
    let code = daemon.finish_within(Duration::from_secs(600)).code;
    let stop = begin.elapsed();
    println!(
        "{backend:8} {way:8} {components:>6} {:>7.0}ms {:>7.0}ms {:>9.1} {:>8.1} {:>8} {:>8} \
         {used:>6.1}% {list:>17} {ports:>17}{}",
        start.as_secs_f64() * 1e3,
        stop.as_secs_f64() * 1e3,
        held.resident as f64 / 1024.0,
        held.shared as f64 / 1024.0,
        held.descriptors,
        held.threads,
        if code == Some(0) { "" } else { "  (ended badly)" },
    );
}

/// The daemon and its cells.
fn processes(home: &Home, daemon: u32) -> Vec<u32> {
    let cells = request(&home.socket(), "GET", "/cells", "").body;
    let cells = cells["cells"].as_array().into_iter().flatten();
    let pids = cells.filter_map(|cell| u32::try_from(cell["pid"].as_u64()?).ok());
    std::iter::once(daemon).chain(pids).collect()
}
