//! A hop from a codel in one cell to a codel in another one, beside a hop with bare iceoryx2; and
//! what the tick of a task costs in a cell and in the process of the daemon.
//!
//! `cargo bench -p genom-tests --bench cell_hop [-- ROUNDS]`; 1,000 values of 64 octets unless told
//! otherwise, one a millisecond. Readers poll, so that no time to wake one is included. The hop of a
//! codel is from before it takes the time and calls `write` until the other codel has the value.
//! The programs are built with `--release`, as users build them; this one is as well.

#![forbid(unsafe_code)]
#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark")]

use std::path::Path;

use genom_bench::Figures;
use genom_bench::bare::Bare as _;
use genom_bench::bare::shm::Iceoryx;
use genom_bench::pair::{Reader, serve};
use genom_tests::trial::FAST;
use genom_tests::{Home, component, fixture, release, request};

const BYTES: usize = 64;
/// Between two values, in microseconds.
const PERIOD: u64 = 1000;
/// Precedes the folder that both processes share, in the arguments of the reading process.
const READER: &str = "--reader";

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    if let [reader, place] = words.as_slice()
        && reader == READER
    {
        let bare = Iceoryx::open(Path::new(place)).expect("a node");
        return serve(|bytes| Ok(vec![bare.reader(bytes)?])).expect("the other process goes on");
    }
    let rounds: usize = words.iter().find_map(|word| word.parse().ok()).unwrap_or(1000);
    let _ = release();
    let made = tempfile::tempdir().expect("a directory");
    let hop = fixture("hop", "hop", made.path());
    let daemon = Home::new().configured(&configuration(&hop)).start(&[]);
    let home = daemon.home();
    assert_eq!(home.get("/ready?wait=60&deployed=true")["ready"], true, "all is connected");
    println!("one hop in us, p50 / p99; a value of {BYTES} octets every {PERIOD} us");
    // In turns, so that a disturbance of the machine affects all of them.
    for _ in 0..3 {
        let bare = bare(rounds);
        let cells = hop_of(home, ["a", "b"], rounds);
        let own = hop_of(home, ["c", "d"], rounds);
        println!(
            "  bare iceoryx2 {bare}   between two cells {cells} {:.2}x   within the daemon, on shm \
             {own} {:.2}x",
            cells.p50 / bare.p50,
            own.p50 / bare.p50
        );
    }
    // A tick without an activity takes less than what microseconds show.
    println!("a task of 1 kHz in ns, p50 / p99");
    for name in ["own", "beside"] {
        let stats = home.get(&format!("/components/{name}/tasks"));
        let figures = |what: &str| {
            let of = &stats["tasks"][0][what];
            let number = |key: &str| of[key].as_u64().expect("a number");
            format!("{} / {}", number("p50_ns"), number("p99_ns"))
        };
        let place = if name == "own" { "in the daemon" } else { "in a cell" };
        println!("  {place:14} tick {}   lateness {}", figures("cycles"), figures("lateness"));
    }
}

/// Two ends in cells, two in the daemon, and two tasks of 1 kHz.
fn configuration(hop: &str) -> String {
    let demo = component("demo").library;
    let mut text = "backend = \"shm\"\n".to_owned();
    for (name, cell) in [("a", "cell = \"a\"\n"), ("b", "cell = \"b\"\n"), ("c", ""), ("d", "")] {
        text += &format!("[[component]]\nlibrary = {hop:?}\nname = {name:?}\n{cell}");
    }
    for (name, cell) in [("own", ""), ("beside", "cell = \"beside\"\n")] {
        text += &format!("[[component]]\nlibrary = {demo:?}\nname = {name:?}\n{cell}{FAST}");
    }
    for (to, from) in [("a", "b"), ("b", "a"), ("c", "d"), ("d", "c")] {
        text += &format!("[[connection]]\nin = \"{to}/from\"\nout = \"{from}/to\"\n");
    }
    text
}

fn bare(rounds: usize) -> Figures {
    let place = tempfile::tempdir().expect("a directory");
    let bare = Iceoryx::open(place.path()).expect("a node");
    let mut ends = [bare.writer(BYTES).expect("a writer")];
    let at = place.path().display().to_string();
    let mut reader = Reader::start(&[READER, &at]).expect("this program starts again");
    reader.open(BYTES).expect("it goes on");
    let measured = reader.measure(&mut ends, rounds, PERIOD * 1000, || true).expect("it goes on");
    reader.finish().expect("it ends well");
    let hops = measured.into_iter().next().expect("one way");
    Figures::of(hops.durations).expect("values arrived")
}

/// From the first of two components to the second one.
fn hop_of(home: &Home, [from, to]: [&str; 2], rounds: usize) -> Figures {
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
