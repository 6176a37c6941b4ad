//! A task compared with bare code in one run: overhead of running a codel, and lateness at 1 kHz.

#![allow(missing_docs, clippy::print_stdout, clippy::unwrap_used)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use rustix::thread::clock_nanosleep_absolute;
use rustix::time::{ClockId, Timespec, clock_gettime};
use support::closures::{Closures, Codel, LONG};

const CALLS: u64 = 5_000_000;
const TICKS: usize = 5000;

fn main() {
    dispatch();
    lateness();
}

/// Time from one codel to the next in a task that never pauses, compared with calling the codel
/// directly.
fn dispatch() {
    let count = Arc::new(AtomicU64::new(0));
    let (sender, ended) = channel();
    let sender = Mutex::new(sender);
    let counted = Arc::clone(&count);
    let codel: Codel = Arc::new(move || {
        let calls = counted.load(Ordering::Relaxed) + 1;
        counted.store(calls, Ordering::Relaxed);
        if calls.is_multiple_of(CALLS) {
            let _ = sender.lock().unwrap().send(());
            return "ether";
        }
        "start"
    });
    let begin = Instant::now();
    while std::hint::black_box(codel()) == "start" {}
    let bare = begin.elapsed().as_secs_f64() * 1e9 / CALLS as f64;
    ended.recv().unwrap();
    let body = Closures::new(
        "component test {
           ids { long a; };
           task t { codel<start> c(inout a) yield start, ether; };
           attribute set(in a);
         };",
        &[("c", codel)],
    );
    let begin = Instant::now();
    let instance = body.start();
    ended.recv().unwrap();
    let task = begin.elapsed().as_secs_f64() * 1e9 / CALLS as f64;
    instance.shutdown(LONG).unwrap();
    println!("codel alone                     {bare:8.1} ns");
    println!("codel in a task, all included   {task:8.1} ns");
}

/// Lateness of wake-ups of a 1 kHz task, compared with a thread that only sleeps; both run at the
/// same time, under the same load.
fn lateness() {
    let bare = std::thread::spawn(|| {
        let _ = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1));
        let nanos = |t: Timespec| t.tv_sec * 1_000_000_000 + t.tv_nsec;
        let mut date = nanos(clock_gettime(ClockId::Monotonic));
        let mut late = Vec::with_capacity(TICKS);
        for _ in 0..TICKS {
            date += 1_000_000;
            let until = Timespec { tv_sec: date / 1_000_000_000, tv_nsec: date % 1_000_000_000 };
            let _ = clock_nanosleep_absolute(ClockId::Monotonic, &until);
            late.push(nanos(clock_gettime(ClockId::Monotonic)) - date);
        }
        late.sort_unstable();
        (late[TICKS / 2], late[TICKS * 99 / 100])
    });
    let (sender, ended) = channel();
    let state = Mutex::new((sender, 0));
    let codel: Codel = Arc::new(move || {
        let mut state = state.lock().unwrap();
        state.1 += 1;
        if state.1 == TICKS {
            let _ = state.0.send(());
        }
        "pause::start"
    });
    let body = Closures::new(
        "component test { task t { period 1 ms; codel<start> c() yield pause::start; }; };",
        &[("c", codel)],
    );
    let instance = body.start();
    ended.recv().unwrap();
    let task = instance.statistics().tasks[0].clone();
    instance.shutdown(LONG).unwrap();
    let (p50, p99) = bare.join().unwrap();
    let ratio = |ours: u64, bare: i64| ours as f64 / bare.max(1) as f64;
    println!("1 kHz, sleep alone        p50 {p50:8} ns   p99 {p99:8} ns");
    println!(
        "1 kHz, task               p50 {:8} ns   p99 {:8} ns   {} overruns",
        task.lateness.p50_ns, task.lateness.p99_ns, task.overruns
    );
    println!(
        "1 kHz, task over alone    p50 {:8.2}      p99 {:8.2}",
        ratio(task.lateness.p50_ns, p50),
        ratio(task.lateness.p99_ns, p99)
    );
}
