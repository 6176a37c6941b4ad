//! Lines per second from text to checked model, at three sizes: the time must grow linearly.

#![allow(missing_docs, clippy::print_stdout)]

mod generate;
mod shapes;

use std::time::{Duration, Instant};

use genom_description::{Options, read_text};

fn main() {
    println!("{:>8} {:>10} {:>12} {:>8}", "lines", "time", "lines/s", "errors");
    for lines in [1_000, 10_000, 100_000] {
        let text = generate::description(lines);
        let count = text.lines().count();
        // The best of a few runs: the others were disturbed by other work of the machine.
        let mut best = Duration::MAX;
        let mut errors = 0;
        for _ in 0..5 {
            let start = Instant::now();
            let analysis = read_text("big.gen", &text, &Options::default());
            best = best.min(start.elapsed());
            errors = analysis.diagnostics.len();
        }
        let rate = count as f64 / best.as_secs_f64();
        println!("{count:>8} {best:>10.1?} {rate:>12.0} {errors:>8}");
    }

    println!("\n{:22} {:>10} {:>10}   (time should grow eightfold)", "", 2_500, 20_000);
    for (name, text) in shapes::all() {
        let time = |count: usize| {
            let text = text(count);
            let start = Instant::now();
            let analysis = read_text("big.gen", &text, &Options::default());
            let elapsed = start.elapsed();
            drop(analysis);
            elapsed
        };
        println!("{name:22} {:>10.1?} {:>10.1?}", time(2_500), time(20_000));
    }
}
