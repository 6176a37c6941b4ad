//! Cost of the exclusion without contention, compared with a mutex in the same run.

#![allow(missing_docs, clippy::print_stdout)]

use std::hint::black_box;
use std::sync::Mutex;
use std::time::Instant;

use genom_runtime::exclusion::Exclusion;
use genom_runtime::plan::Nodes;

const CALLS: u32 = 5_000_000;
const ROUNDS: usize = 5;

/// The best of several rounds, in nanoseconds per call: the others were disturbed by other work.
fn measure(name: &str, mut call: impl FnMut()) {
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        (0..CALLS).for_each(|_| call());
        best = best.min(begin.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS));
    }
    println!("{name:<44} {best:6.1} ns");
}

fn main() {
    let mutex = Mutex::new(0u64);
    measure("std Mutex, lock and unlock", || {
        if let Ok(mut guard) = mutex.lock() {
            *guard += 1;
        }
    });
    let pairs: Vec<(usize, usize)> = (0..20).map(|a| (a, (a + 1) % 20)).collect();
    let few = Exclusion::new(&Nodes::of_pairs(20, &pairs), 4);
    measure("exclusion, node with conflicts", || drop(black_box(few.enter(0, black_box(3)))));
    let free = Exclusion::new(&Nodes::of_pairs(20, &[]), 4);
    measure("exclusion, node without conflicts", || drop(black_box(free.enter(0, black_box(3)))));
    let pairs: Vec<(usize, usize)> = (0..200).map(|a| (a, (a + 1) % 200)).collect();
    let many = Exclusion::new(&Nodes::of_pairs(200, &pairs), 4);
    measure("exclusion, 200 nodes with conflicts", || {
        drop(black_box(many.enter(0, black_box(150))));
    });
    measure("exclusion of everything", || drop(black_box(few.enter_all(0, None))));
}
