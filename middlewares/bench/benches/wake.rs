//! How long a sending thread takes to notice a sample of a periodic writer, and what it costs.
//!
//! `cargo bench -p genom-bench --bench wake`

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program that prints figures")]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use genom_bench::{Figures, clock};
use genom_middleware::bell::Bell;
use genom_middleware::forecast::Forecast;
use rustix::time::{ClockId, clock_gettime};

const ROUNDS: u64 = 1000;

/// Seconds of processor time of this thread.
fn busy() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 / 1e9
}

/// Figures of the delay, and the share of a processor that the thread took.
fn measure(percent: u8, period: u64) -> (Figures, f64) {
    let (bell, sent) = (Arc::new(Bell::default()), Arc::new(AtomicU64::new(0)));
    let done = Arc::new(AtomicBool::new(false));
    let listener = {
        let (bell, sent, done) = (Arc::clone(&bell), Arc::clone(&sent), Arc::clone(&done));
        thread::spawn(move || {
            let (mut forecast, mut delays) = (Forecast::new(percent), Vec::new());
            let (start, before) = (Instant::now(), busy());
            while !done.load(Ordering::Acquire) {
                forecast.wait(&bell, Duration::from_secs(3600));
                let date = sent.swap(0, Ordering::AcqRel);
                if date != 0 {
                    forecast.heard(0, Instant::now());
                    delays.push((clock::now() - date) as f64);
                }
            }
            let share = (busy() - before) / start.elapsed().as_secs_f64();
            (Figures::of(delays), share)
        })
    };
    let mut date = clock::now();
    for _ in 0..ROUNDS {
        date += period;
        clock::sleep_until(date);
        sent.store(clock::now(), Ordering::Release);
        bell.ring();
    }
    done.store(true, Ordering::Release);
    bell.ring();
    listener.join().unwrap()
}

fn main() {
    println!("from a ring to the thread at work, p50 / p99 in us, and percent of a processor");
    println!("{:>10} {:>26} {:>26}", "period", "asleep", "expecting (15 %)");
    for period in [1, 4, 10] {
        let show = |percent| {
            let (figures, share) = measure(percent, period * 1_000_000);
            format!("{figures} {:>6.1} %", share * 100.0)
        };
        println!("{:>7} ms {:>26} {:>26}", period, show(0), show(15));
    }
}
