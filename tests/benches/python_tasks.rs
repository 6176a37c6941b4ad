//! What Python and Lua cost a component: a call of a codel, and how late its tasks begin.
//!
//! `cargo bench -p genom-tests --bench python_tasks [-- SECONDS]`, 20 s unless told otherwise. Printed:
//! what a codel costs that reads three fields of the IDS and writes three, beside an empty one; then how
//! late a period of 1 kHz begins of the demo in Python, of that in Lua and of the demo in C, all with an activity that
//! runs, each in a cell, side by side for the same time, first with nothing else and then in a daemon
//! with ten more components of 1 kHz, of which four clients read all values as fast as they can. The
//! programs are built with `--release`; with `-- debug`, as the tests build them. Tasks are real-time
//! where that is permitted (`CAP_SYS_NICE`).

#![forbid(unsafe_code)]
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a benchmark, which measures for a time"
)]

use std::collections::BTreeMap;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use genom_tests::trial::{FAST, task_of_1_khz};
use genom_tests::{Home, Running, component, release, repository};

/// Components that load the daemon, and clients that ask it.
const OTHERS: usize = 10;
const CLIENTS: usize = 4;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let seconds = words.iter().find_map(|word| word.parse().ok()).unwrap_or(20);
    if !words.iter().any(|word| word == "debug") {
        let _ = release();
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut library = Command::new(cargo);
        library.current_dir(repository()).args([
            "build",
            "--release",
            "-p",
            "genom-runner",
            "-p",
            "genom-lua",
        ]);
        assert!(library.status().expect("cargo runs").success(), "the library does not build");
    }
    calls();
    in_lua();
    println!("\nlateness of a period of 1 kHz, µs            p50        p99    periods");
    lateness("alone", "", 0, Duration::from_secs(seconds));
    let others: String = (0..OTHERS).map(|n| task_of_1_khz(&format!("other{n}"))).collect();
    lateness("loaded", &others, CLIENTS, Duration::from_secs(seconds));
}

/// The costs of calls, as the benchmark of the Python package measures them.
fn calls() {
    let package = repository().join("clients/python");
    let mut command = Command::new(std::env::var_os("PYTHON").unwrap_or("python3".into()));
    command.arg("benches/codels.py").current_dir(&package);
    command.env("PYTHONPATH", format!("{}:.", package.join("src").display()));
    let finished = Running::start(&mut command).finish();
    finished.expect_code(0);
    let row = |what: &str| {
        let line = finished.out.lines().find(|line| line.ends_with(what)).expect("the row");
        line.split_whitespace().next().and_then(|cost| cost.parse::<f64>().ok()).expect("a number")
    };
    let (empty, used) = (row("empty, no arguments"), row("three doubles read and written"));
    println!("{}", finished.out.trim_end());
    println!(
        "three fields read and three written: {:.2} µs over an empty codel, {:.1} times it",
        used - empty,
        used / empty
    );
}

/// The same of codels in Lua, as the benchmark of their runner measures them.
fn in_lua() {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(repository()).args(["bench", "-q", "-p", "genom-lua", "--bench", "calls"]);
    let finished = Running::start(&mut command).finish();
    finished.expect_code(0);
    println!("{}", finished.out.trim_end());
}

/// The demos, by the names of their instances.
const DEMOS: [(&str, &str); 3] = [("c", "demo"), ("python", "demo-py"), ("lua", "demo-lua")];

/// Prints how late the tasks of the demos begin, and the ratio to that in C.
fn lateness(how: &str, others: &str, clients: usize, time: Duration) {
    let of = |lang: &str, name: &str| {
        let library = component(name).library;
        format!("[[component]]\nlibrary = {library:?}\nname = {lang:?}\ncell = {lang:?}\n{FAST}")
    };
    let all: String = DEMOS.iter().map(|(lang, name)| of(lang, name)).collect();
    let daemon = Home::new().configured(&(all + others)).start(&[]);
    assert_eq!(daemon.home().get("/ready?wait=60&deployed=true")["ready"], true, "all is loaded");
    for (name, _) in DEMOS {
        // It stands still and goes on to move, so that a codel runs in each period.
        daemon.ctl(&["pub", &format!("{name}/parameter"), "0"]).expect_code(0);
        daemon.ctl(&["start", name, "goto", "goal=1"]).expect_code(0);
    }
    let (home, over) = (daemon.home(), AtomicBool::new(false));
    std::thread::scope(|scope| {
        for _ in 0..clients {
            scope.spawn(|| {
                while !over.load(Ordering::Relaxed) {
                    let _ = home.get("/ports");
                }
            });
        }
        std::thread::sleep(Duration::from_secs(1));
        let before = DEMOS.map(|(name, _)| buckets(home, name));
        std::thread::sleep(time);
        let after = DEMOS.map(|(name, _)| buckets(home, name));
        over.store(true, Ordering::Relaxed);
        let each = [0, 1, 2].map(|at: usize| percentiles(&before[at], &after[at]));
        for ((name, _), [p50, p99, count]) in DEMOS.iter().zip(each) {
            let (half, most) = (p50 / each[0][0], p99 / each[0][1]);
            println!(
                "{how:8} {name:10} {p50:>9.1} ({half:.2} of C)  {p99:>9.1} ({most:.2} of C)  {count:>9}"
            );
        }
    });
}

/// How many periods of the task were at most so many nanoseconds late.
fn buckets(home: &Home, name: &str) -> BTreeMap<u64, u64> {
    let told = home.get(&format!("/components/{name}/tasks/histograms"));
    let all = told["tasks"][0]["lateness"].as_array().expect("a histogram");
    let number = |one: &serde_json::Value, key: &str| one[key].as_u64().expect("a number");
    all.iter().map(|one| (number(one, "most_ns"), number(one, "count"))).collect()
}

/// Median and 99th percentile between two readings in µs, to an eighth, and the number of periods.
fn percentiles(before: &BTreeMap<u64, u64>, after: &BTreeMap<u64, u64>) -> [f64; 3] {
    let new = |most: &u64, count: &u64| count - before.get(most).copied().unwrap_or_default();
    let new: Vec<(u64, u64)> =
        after.iter().map(|(most, count)| (*most, new(most, count))).collect();
    let total: u64 = new.iter().map(|(_, count)| count).sum();
    let at = |part: u64| {
        let mut seen = 0;
        let found = new.iter().find(|(_, count)| {
            seen += count;
            seen * 100 >= total * part
        });
        found.map_or(f64::NAN, |(most, _)| *most as f64 / 1e3)
    };
    [at(50), at(99), total as f64]
}
