//! What many reloads of a component with a changing library cost it, others and their process.
//!
//! `cargo bench -p genom-tests --bench reloads [-- RELOADS]`; 1,000 in the daemon's own process and as many
//! in a cell, with the same description and with another one each time, unless told otherwise. The component and another one beside it have tasks of 1 kHz that
//! read each other, an activity runs, and requests come all the time. That IDS, activity and ports are as
//! without reloads is asserted. Printed: periods missed with and without reloads, and what the
//! process holds after the first ten and after all. The programs are built with `--release`.

#![forbid(unsafe_code)]
#![allow(clippy::print_stdout, reason = "a benchmark")]

use genom_tests::reloads::{Held, reloads};

fn main() {
    let mut words = std::env::args().skip(1).filter_map(|word| word.parse().ok());
    let times: usize = words.next().unwrap_or(1000);
    let _ = genom_tests::release();
    for (in_cell, described) in [(false, false), (true, false), (false, true), (true, true)] {
        let did = reloads(times, in_cell, described);
        let place = if in_cell { "a cell" } else { "the daemon's own process" };
        let [own, beside] = did.missed_without;
        let with = if described { "another description" } else { "the same description" };
        println!("{times} reloads in {place}, {with}, {:.0} s", did.elapsed.as_secs_f64());
        println!("  periods made: {}", did.periods);
        println!("  periods missed: {}, in as much time without reloads: {own}", did.missed);
        println!("  periods lost by its own clock: {}, without: {}", did.lost, did.lost_without);
        println!("  missed beside it: {}, without: {beside}", did.missed_beside);
        told("after ten", did.before);
        told("after all", did.after);
    }
}

fn told(when: &str, held: Held) {
    let (of, maps) = (held.footprint, held.maps);
    println!(
        "  {when}: {} KiB resident, {} descriptors, {} threads, {maps} mappings",
        of.resident, of.descriptors, of.threads
    );
}
