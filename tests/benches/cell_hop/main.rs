//! A hop from a codel in one cell to a codel in another one, beside a hop with bare iceoryx2; and
//! what the tick of a task costs in a cell and in the process of the daemon.
//!
//! `cargo bench -p genom-tests --bench cell_hop [-- BLOCKS [ROUNDS]]`; 30 blocks of 200 values of 64
//! octets unless told otherwise, one value a millisecond. Bare iceoryx2, two cells, and two
//! components within the daemon take turns, block by block, so that what changes on the machine
//! changes for all of them; a ratio is that of two blocks that follow each other. All do the same:
//! one end sends a value with its time, the other one answers how old it was, both poll, and each is
//! kept on a processor of its own. The programs are built with `--release`; this one is as well.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark")]

mod bare;

use std::path::Path;

use genom_bench::Figures;
use genom_tests::trial::FAST;
use genom_tests::{Home, component, fixture, release, request};

use bare::{BYTES, Pair};

/// Between two values, in microseconds.
const PERIOD: u64 = 1000;
/// Precedes the folder that both processes share and the processor, in the arguments of the process
/// that answers.
const ECHO: &str = "--echo";
/// Processors of the end that asks and of the one that answers.
const ENDS: [usize; 2] = [0, 1];
/// Ticks of which the cost is told.
const TICKS: u64 = 5000;

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    if let [echo, place, processor] = words.as_slice()
        && echo == ECHO
    {
        return bare::echo(Path::new(place), processor.parse().expect("a number"));
    }
    let mut numbers = words.iter().filter_map(|word| word.parse().ok());
    let (blocks, rounds) = (numbers.next().unwrap_or(30), numbers.next().unwrap_or(200));
    let _ = release();
    hops(blocks, rounds);
    ticks();
}

fn hops(blocks: u64, rounds: u64) {
    let made = tempfile::tempdir().expect("a directory");
    let hop = fixture("hop", "hop", made.path());
    let daemon = Home::new().configured(&ends(&hop)).start(&[]);
    let home = daemon.home();
    assert_eq!(home.get("/ready?wait=60&deployed=true")["ready"], true, "all is connected");
    let place = tempfile::tempdir().expect("a directory");
    let mut pair = Pair::start(place.path(), ECHO, ENDS);
    let mut all: [Vec<Figures>; 3] = Default::default();
    for block in 0..blocks {
        // The other way round in each second block: none always comes after the same one.
        for turn in 0..3 {
            let way = if block % 2 == 0 { turn } else { 2 - turn };
            all[way as usize].push(match way {
                0 => pair.measure(rounds, PERIOD * 1000),
                1 => hop_of(home, ["a", "b"], rounds),
                _ => hop_of(home, ["c", "d"], rounds),
            });
        }
    }
    pair.end();
    println!(
        "one hop in us; a value of {BYTES} octets every {PERIOD} us, {blocks} blocks of {rounds}: \
         median of the blocks' p50 (first and third quartile), median of their p99"
    );
    let [bare, cells, own] = &all;
    for (name, ours) in [("bare iceoryx2", bare), ("between two cells", cells), ("within", own)] {
        let of = |one: &dyn Fn(&Figures) -> f64| quartiles(ours.iter().map(one).collect());
        let ([first, middle, third], [_, p99, _]) = (of(&|f| f.p50 / 1e3), of(&|f| f.p99 / 1e3));
        let ratios = ours.iter().zip(bare).map(|(ours, bare)| ours.p50 / bare.p50).collect();
        let [least, ratio, most] = quartiles(ratios);
        println!(
            "  {name:18} {middle:6.2} ({first:.2} to {third:.2})   p99 {p99:6.2}   {ratio:.2} x bare \
             ({least:.2} to {most:.2})"
        );
    }
}

/// What a tick in which an activity runs a codel costs, and how late it is.
fn ticks() {
    let daemon = Home::new().configured(&moving()).start(&[]);
    let home = daemon.home();
    assert_eq!(home.get("/ready?wait=60&deployed=true")["ready"], true, "all is there");
    println!("a task of 1 kHz with an activity, in ns, p50 / p99");
    for (name, place) in [("own", "in the daemon"), ("beside", "in a cell")] {
        let stats = loop {
            let stats = home.get(&format!("/components/{name}/tasks"));
            if stats["tasks"][0]["cycles"]["count"].as_u64().expect("a number") > TICKS {
                break stats;
            }
        };
        let figures = |what: &str| {
            let of = &stats["tasks"][0][what];
            let number = |key: &str| of[key].as_u64().expect("a number");
            format!("{} / {}", number("p50_ns"), number("p99_ns"))
        };
        println!("  {place:14} tick {}   lateness {}", figures("cycles"), figures("lateness"));
    }
}

/// Two ends in cells and two in the daemon, each on its processor.
fn ends(hop: &str) -> String {
    let mut text = "backend = \"shm\"\n".to_owned();
    let [asks, answers] = ENDS;
    for (name, cell, processor) in [
        ("a", "cell = \"a\"\n", asks),
        ("b", "cell = \"b\"\n", answers),
        ("c", "", asks),
        ("d", "", answers),
    ] {
        text += &format!(
            "[[component]]\nlibrary = {hop:?}\nname = {name:?}\n{cell}[component.tasks.main]\n\
             cpus = [{processor}]\n"
        );
    }
    for (to, from) in [("a", "b"), ("b", "a"), ("c", "d"), ("d", "c")] {
        text += &format!("[[connection]]\nin = \"{to}/from\"\nout = \"{from}/to\"\n");
    }
    text
}

/// Two axes that move for as long as this takes, at 1 kHz.
fn moving() -> String {
    let demo = component("demo").library;
    let mut text = "backend = \"shm\"\n".to_owned();
    for (name, cell) in [("own", ""), ("beside", "cell = \"beside\"\n")] {
        text += &format!("[[component]]\nlibrary = {demo:?}\nname = {name:?}\n{cell}{FAST}");
    }
    for name in ["own", "beside"] {
        text += &format!(
            "[[call]]\ncomponent = {name:?}\nservice = \"set_speed\"\ninputs = {{ velocity = 0.001 }}\n\
             [[activity]]\ncomponent = {name:?}\nservice = \"goto\"\ninputs = {{ goal = 0.9 }}\n"
        );
    }
    text
}

/// From the first of two components to the second one.
fn hop_of(home: &Home, [from, to]: [&str; 2], rounds: u64) -> Figures {
    let call = |of: &str, service: &str, inputs: &str| {
        let path = format!("/components/{of}/services/{service}");
        let reply = request(&home.socket(), "POST", &path, inputs);
        assert!(reply.status < 300, "{reply:?}");
        reply.body
    };
    let echo = call(to, "echo", &format!("{{\"rounds\": {rounds}}}"));
    assert!(echo["activity"].is_number(), "{echo}");
    let inputs = format!("{{\"rounds\": {rounds}, \"period\": {PERIOD}}}");
    let ended = call(from, "ping?wait=true", &inputs);
    let number = |key: &str| ended["result"][key].as_f64().expect("a number");
    Figures { p50: number("p50"), p99: number("p99") }
}

/// First quartile, median, third quartile.
fn quartiles(mut all: Vec<f64>) -> [f64; 3] {
    all.sort_unstable_by(f64::total_cmp);
    let last = all.len().checked_sub(1).expect("there are blocks");
    [1, 2, 3].map(|quarter| all[last * quarter / 4])
}
