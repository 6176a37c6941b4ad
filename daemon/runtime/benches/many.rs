//! 64 tasks at 1 kHz in one instance compared with 64 bare threads, alternately in one run: missed
//! ticks and lateness.

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::num::NonZeroU64;
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};
use support::closures::{Closures, Codel, LONG};

const TASKS: usize = 64;
const TICKS: usize = 3000;
const PERIOD: u64 = 1_000_000;
const ROUNDS: usize = 3;

/// Ticks missed by all of them together, and lateness in nanoseconds: median of their p50, and of
/// their p99.
struct Figures {
    missed: u64,
    p50: u64,
    p99: u64,
}

fn main() {
    println!("{TASKS} at 1 kHz, {TICKS} ticks each          missed         p50         p99");
    for _ in 0..ROUNDS {
        for (name, figures) in [("bare threads", bare()), ("tasks", tasks())] {
            let Figures { missed, p50, p99 } = figures;
            println!("{name:<35} {missed:10} {p50:8} ns {p99:8} ns");
        }
    }
}

fn now() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.unsigned_abs() * 1_000_000_000 + now.tv_nsec.unsigned_abs()
}

/// The same with bare threads.
fn bare() -> Figures {
    let start = now() + 10 * PERIOD;
    let work = move || {
        let _ = rustix::thread::set_current_timer_slack(NonZeroU64::new(1));
        let (mut date, mut missed) = (start, 0);
        let mut late = Vec::with_capacity(TICKS);
        for _ in 0..TICKS {
            let until = Timespec {
                tv_sec: i64::try_from(date / 1_000_000_000).unwrap(),
                tv_nsec: i64::try_from(date % 1_000_000_000).unwrap(),
            };
            let _ = clock_nanosleep_absolute(ClockId::Monotonic, &until);
            let woke = now();
            late.push(woke - date);
            // As a task does: missed ticks are skipped, not caught up with.
            let over = (woke - date) / PERIOD;
            missed += over;
            date += (over + 1) * PERIOD;
        }
        late.sort_unstable();
        (missed, late[TICKS / 2], late[TICKS * 99 / 100])
    };
    let threads: Vec<_> = (0..TASKS).map(|_| std::thread::spawn(work)).collect();
    summary(threads.into_iter().map(|thread| thread.join().unwrap()).collect())
}

fn tasks() -> Figures {
    let text: String = (0..TASKS)
        .map(|n| format!("task t{n} {{ period 1 ms; codel<start> c{n}() yield pause::start; }};"))
        .collect();
    let names: Vec<String> = (0..TASKS).map(|n| format!("c{n}")).collect();
    let (sender, ended) = channel();
    let codel = || -> Codel {
        let state = Mutex::new((sender.clone(), 0, 0));
        Arc::new(move || {
            let mut state = state.lock().unwrap();
            let (sender, calls, first) = &mut *state;
            *calls += 1;
            if *calls == 1 {
                *first = now();
            }
            if *calls == TICKS {
                let ticks = (now() - *first + PERIOD / 2) / PERIOD;
                let _ = sender.send(ticks - (TICKS as u64 - 1));
            }
            "pause::start"
        })
    };
    let codels: Vec<(&str, Codel)> = names.iter().map(|name| (name.as_str(), codel())).collect();
    let body = Closures::new(&format!("component test {{ {text} }};"), &codels);
    let instance = body.start();
    let missed = (0..TASKS).map(|_| ended.recv().unwrap()).sum();
    let tasks = instance.statistics().tasks;
    instance.shutdown(LONG).unwrap();
    let late = tasks.iter().map(|task| (0, task.lateness.p50_ns, task.lateness.p99_ns));
    Figures { missed, ..summary(late.collect()) }
}

fn summary(all: Vec<(u64, u64, u64)>) -> Figures {
    let median = |mut figures: Vec<u64>| {
        figures.sort_unstable();
        figures[figures.len() / 2]
    };
    Figures {
        missed: all.iter().map(|(missed, ..)| missed).sum(),
        p50: median(all.iter().map(|(_, p50, _)| *p50).collect()),
        p99: median(all.iter().map(|(.., p99)| *p99).collect()),
    }
}
