//! Ten million ticks of eight tasks as fast as possible, with requests and activities at the same
//! time: prints the memory of the process, and fails when it grows.
//!
//! `cargo bench -p genom-runtime --bench soak [-- MILLIONS]`

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use support::closures::{Closures, Codel, LONG, next, request};

const TASKS: usize = 8;
/// Variation of the resident memory that is due to the system.
const SLACK_KIB: u64 = 256;

fn main() -> ExitCode {
    let millions = std::env::args().skip(1).find_map(|word| word.parse().ok()).unwrap_or(10);
    let wanted: u64 = millions * 1_000_000;
    // Neighbours exclude each other; each task also runs activities that start and end.
    let ids: String = (0..TASKS).map(|n| format!("long v{n};")).collect();
    let tasks: String = (0..TASKS)
        .map(|n| {
            let other = (n + 1) % TASKS;
            format!(
                "task t{n} {{ period 1 us;
                   codel<start> tick{n}(inout v{n}, in v{other}) yield pause::start; }};
                 activity a{n}() {{ task t{n};
                   codel<start> begin{n}() yield main;
                   codel<main> run{n}(inout v{n}) yield pause::main, ether;
                   codel<stop> end{n}() yield ether; interrupts a{n}; }};"
            )
        })
        .collect();
    let text = format!("component test {{ ids {{ {ids} }}; {tasks} attribute set(in v0); }};");
    let count = Arc::new(AtomicU64::new(0));
    let mut named: Vec<(String, Codel)> = Vec::new();
    for n in 0..TASKS {
        let counted = Arc::clone(&count);
        let tick: Codel = Arc::new(move || {
            counted.fetch_add(1, Ordering::Relaxed);
            "pause::start"
        });
        named.push((format!("tick{n}"), tick));
        named.push((format!("begin{n}"), Arc::new(|| "main")));
        named.push((format!("run{n}"), Arc::new(|| "pause::main")));
        named.push((format!("end{n}"), Arc::new(|| "ether")));
    }
    let codels: Vec<(&str, Codel)> =
        named.iter().map(|(name, codel)| (name.as_str(), Arc::clone(codel))).collect();
    let body = Closures::new(&text, &codels);
    let instance = body.start();
    let begin = Instant::now();
    let (mut reports, mut requests, mut first) = (0, 0_u64, 0);
    let mut running: Vec<_> = (0..TASKS).map(|n| request(&instance, &format!("a{n}"))).collect();
    while count.load(Ordering::Relaxed) < wanted {
        let at = usize::try_from(requests).unwrap_or(0) % TASKS;
        assert_eq!(next(&request(&instance, "set")), "done");
        // The new one interrupts the old one, which ends or never starts.
        let new = request(&instance, &format!("a{at}"));
        let old = std::mem::replace(&mut running[at], new);
        while next(&old).starts_with("accepted") {}
        requests += 2;
        if count.load(Ordering::Relaxed) * 10 / wanted > reports {
            reports += 1;
            let memory = memory_kib();
            // The first tenth fills buffers that are kept for reuse.
            if reports == 1 {
                first = memory;
            }
            println!(
                "{:>11} ticks {requests:>9} requests {memory:>8} KiB {:>+6} KiB",
                count.load(Ordering::Relaxed),
                memory.cast_signed() - first.cast_signed()
            );
        }
    }
    let growth = memory_kib().saturating_sub(first);
    let seconds = begin.elapsed().as_secs_f64();
    instance.shutdown(LONG).unwrap();
    let ticks = count.load(Ordering::Relaxed);
    let rate = ticks as f64 / seconds / 1e6;
    println!("{ticks} ticks of {TASKS} tasks in {seconds:.1} s ({rate:.2} million a second)");
    println!("growth after the first tenth: {growth} KiB");
    if growth > SLACK_KIB { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

/// Resident memory of the process.
fn memory_kib() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
    line.trim().trim_end_matches(" kB").parse().unwrap()
}
