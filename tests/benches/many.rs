//! Cost of many components: 1, 50 and 500 with five ports each, on local and shared memory.
//! Measures the time until ready, stop, memory, file descriptors, processor time while nobody asks
//! for anything, and the duration of `list` and `ports`; with a thread for each task, and with one
//! for all (`execution`).
//!
//! `cargo bench -p genom-tests --bench many [-- BACKEND... EXECUTION... NUMBER...]`. The programs are built with
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
/// Ways to execute components.
const EXECUTIONS: [&str; 2] = ["threads", "single"];

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let numbers: Vec<usize> = words.iter().filter_map(|word| word.parse().ok()).collect();
    let numbers = if numbers.is_empty() { vec![1, 50, 500] } else { numbers };
    let names =
        || words.iter().map(String::as_str).filter(|word: &&str| word.parse::<usize>().is_err());
    let (ways, backends): (Vec<&str>, Vec<&str>) =
        names().partition(|name| EXECUTIONS.contains(name));
    let ways = if ways.is_empty() { EXECUTIONS.to_vec() } else { ways };
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
    let text = Many { components, chained: false }.configuration(backend, made.path());
    let home = Home::new().configured(&text);
    let mut command = Command::new(genomd);
    command.arg("--config").arg(home.path().join("genomd.toml"));
    command.arg("--socket").arg(home.socket()).args(["--execution", way]);
    let begin = Instant::now();
    let daemon = Running::start(&mut command);
    let ready = daemon.error_line_where(|line| line.contains("ready on "));
    let start = begin.elapsed();
    if ready.is_none() {
        let said = daemon.finish().err;
        println!("{backend:8} {components:>6} refused: {}", said.lines().last().unwrap_or(""));
        return;
    }
    let held = Footprint::of(daemon.id());
    let (at, before) = (Instant::now(), processor_time(daemon.id()));
    while at.elapsed() < IDLE {
        std::thread::park_timeout(IDLE.saturating_sub(at.elapsed()));
    }
    let used = processor_time(daemon.id()).saturating_sub(before);
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
