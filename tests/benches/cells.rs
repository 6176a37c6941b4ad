//! What becomes of others, and of what was in a cell, when the cell's process or the daemon is killed.
//!
//! `cargo bench -p genom-tests --bench cells [-- KILLS]`; 100 kills of each unless told otherwise.
//! A component in a cell that reads a port of another cell is killed again and again; a third one
//! beside them, and one of the daemon's own, have a task of 1 kHz. Printed: the time from the kill
//! until the cell answers, and until its in port is connected again; periods that the others missed;
//! descriptors of the daemon. Then the daemon is killed as often. The tasks of 1 kHz are real-time where
//! that is permitted (`CAP_SYS_NICE`). The programs are built with `--release`.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark")]

use std::path::Path;
use std::process::Command;
use std::time::{Duration, Instant};

use genom_tests::{Footprint, Home, Running, component, release, request};
use serde_json::Value;

fn main() {
    let mut words = std::env::args().skip(1).filter_map(|word| word.parse().ok());
    let kills: usize = words.next().unwrap_or(100);
    let genomd = release();
    let home = Home::new().configured(&configuration());
    let mut daemon = Some(start(&genomd, &home));
    wait(&home, "/ready?wait=30&deployed=true");
    // What the machine itself lets a task miss: nobody in this daemon's processes is killed.
    let apart = Home::new().configured(&task_of_1_khz("apart"));
    let _apart = start(&genomd, &apart);
    let missed = [missed(&home, "own"), missed(&home, "beside"), missed(&apart, "apart")];
    let mut answers = Vec::new();
    let mut wired = Vec::new();
    for _ in 0..kills {
        let pid = pid(&home, "base");
        let begin = Instant::now();
        signal(pid);
        until(|| pid_now(&home, "base").is_some_and(|now| now != pid));
        answers.push(begin.elapsed());
        until(|| get(&home, "/components/demo/ports/parameter")["connected"] == "mission/gain");
        wired.push(begin.elapsed());
    }
    println!("{kills} kills of a cell");
    line("  until it answers", &mut answers);
    line("  until it is configured and wired", &mut wired);
    told("  missed by the daemon's own task of 1 kHz", missed_since(&home, "own", missed[0]));
    told("  missed by the task of another cell", missed_since(&home, "beside", missed[1]));
    told("  missed by the task of a daemon apart", missed_since(&apart, "apart", missed[2]));
    let held = Footprint::of(daemon.as_ref().map_or(0, Running::id));
    println!("  descriptors of the daemon: {}", held.descriptors);
    let before = [missed_since(&home, "beside", 0), missed_since(&apart, "apart", 0)];
    let cell = pid(&home, "beside");
    let mut adopted = Vec::new();
    for _ in 0..kills {
        let begin = Instant::now();
        // The next one listens on the same socket as soon as this one is gone.
        drop(daemon.take());
        daemon = Some(start(&genomd, &home));
        adopted.push(begin.elapsed());
    }
    println!("{kills} kills of the daemon");
    line("  until the next one answers for its cells", &mut adopted);
    told("  missed by the task of a cell", missed_since(&home, "beside", before[0]));
    told("  missed by the task of a daemon apart", missed_since(&apart, "apart", before[1]));
    println!("  the same process all along: {}", pid(&home, "beside") == cell);
    drop(daemon);
}

/// A writer and a reader in two cells, and two bystanders with tasks of 1 kHz.
fn configuration() -> String {
    let (demo, mission) = (component("demo").library, component("mission").library);
    let (own, beside) = (task_of_1_khz("own"), task_of_1_khz("beside"));
    // The name of the cell goes before the tables of a component.
    let beside = beside.replacen("name", "cell = \"beside\"\nname", 1);
    format!(
        "[cells]\nrestart_most = 1000000\nrestart_delay = 0.0\n{own}{beside}\
         [[component]]\nlibrary = {demo:?}\ncell = \"base\"\n\
         [[component]]\nlibrary = {mission:?}\ncell = \"brain\"\n\
         [[connection]]\nin = \"demo/parameter\"\nout = \"mission/gain\"\n\
         [[connection]]\nin = \"mission/goto\"\nout = \"demo/goto\"\n"
    )
}

/// A demo whose task is real-time and at 1 kHz.
fn task_of_1_khz(name: &str) -> String {
    let demo = component("demo").library;
    format!(
        "[[component]]\nlibrary = {demo:?}\nname = {name:?}\n\
         [component.tasks.main]\nperiod_ms = 1.0\nreal_time = true\npriority = 10\n"
    )
}

fn start(genomd: &Path, home: &Home) -> Running {
    let mut command = Command::new(genomd);
    command.arg("--config").arg(home.path().join("genomd.toml"));
    command.arg("--socket").arg(home.socket());
    let daemon = Running::start(&mut command);
    daemon.error_line_where(|line| line.contains("ready on "));
    daemon
}

fn get(home: &Home, path: &str) -> Value {
    request(&home.socket(), "GET", path, "").body
}

fn wait(home: &Home, path: &str) {
    assert_eq!(get(home, path)["ready"], true, "everything is wired");
}

fn until(mut so: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(30);
    while !so() {
        assert!(Instant::now() < end, "it does not come back");
    }
}

fn pid_now(home: &Home, cell: &str) -> Option<u64> {
    let cells = get(home, "/cells");
    let found = cells["cells"].as_array()?.iter().find(|one| one["name"] == cell)?.clone();
    found["pid"].as_u64().filter(|_| found["state"] == "running")
}

fn pid(home: &Home, cell: &str) -> u64 {
    pid_now(home, cell).expect("a process")
}

fn signal(pid: u64) {
    let sent = Command::new("kill").args(["-s", "KILL", &pid.to_string()]).status();
    assert!(sent.expect("kill runs").success());
}

fn missed(home: &Home, component: &str) -> u64 {
    let tasks = get(home, &format!("/components/{component}/tasks"));
    let tasks = tasks["tasks"].as_array().expect("tasks").iter();
    tasks.map(|task| task["overruns"].as_u64().expect("a number")).sum()
}

fn missed_since(home: &Home, component: &str, before: u64) -> u64 {
    missed(home, component) - before
}

fn told(what: &str, periods: u64) {
    println!("{what}: {periods} periods");
}

fn line(what: &str, times: &mut [Duration]) {
    times.sort_unstable();
    let at =
        |part: usize| times[(times.len() * part / 100).min(times.len() - 1)].as_secs_f64() * 1e3;
    println!("{what}: p50 {:.1} ms, p99 {:.1} ms", at(50), at(99));
}
