//! Cost of a port within the process as components use it (exchangeable ends and counters
//! included), compared with the bare exchange and with two copies of the bytes.
//!
//! `cargo bench -p genom-ports --bench ports`

#![allow(missing_docs, clippy::expect_used, clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use genom_local::Local;
use genom_middleware::{Address, Policy, PortSpec, Ports as _, Publisher, Subscription};
use genom_ports::{Fan, Tap};
use genom_runtime::Clock;
use genom_types::{DataType, Kind, Record, TypeTable};

const CALLS: u32 = 10_000;
const ROUNDS: usize = 500;

/// The fastest of many short rounds, in nanoseconds per call; slower rounds were disturbed by other
/// work of the machine.
fn measure(name: &str, mut call: impl FnMut()) {
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let begin = Instant::now();
        (0..CALLS).for_each(|_| call());
        best = best.min(begin.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS));
    }
    println!("{name:<52} {best:6.1} ns");
}

fn main() {
    let mut table = TypeTable::default();
    let element = table.add(Kind::Octet);
    let id = table.add(Kind::Array { element, length: 64 });
    let ty = DataType::new(&table.into(), id).expect("a type that can be laid out");
    let (sent, mut got) = (Record::new(&ty), Record::new(&ty));
    let (mut between, mut last) = ([0; 64], [0; 64]);
    measure("64 bytes copied twice", || {
        between.copy_from_slice(black_box(sent.bytes().unwrap_or_default()));
        last.copy_from_slice(black_box(&between));
        black_box(&mut last);
    });
    let at = Address::new("bench", "port");
    let ends = |local: &Local| {
        let writer = local.publisher(&PortSpec::new(&at, &ty)).expect("an out port");
        let reader =
            local.subscription(&PortSpec::new(&at, &ty), Policy::Latest).expect("an in port");
        (writer, reader)
    };
    let mut hop =
        |name: &str, mut writer: Box<dyn Publisher>, mut reader: Box<dyn Subscription>| {
            measure(name, || {
                let _ = black_box(writer.publish(black_box(&sent)));
                let _ = black_box(reader.read(&mut got));
            });
        };
    let local = Local::new();
    let (writer, reader) = ends(&local);
    hop("64 bytes written and read, exchange alone", writer, reader);
    let local = Local::new();
    let (writer, reader) = ends(&local);
    let fan = Fan::new(vec![("local".to_owned(), writer)], &Clock::Monotonic, &ty);
    let tap = Tap::new(reader, &Clock::Monotonic, &ty);
    hop("64 bytes written and read, as components do", fan.publisher(), tap.subscription());
}
