//! A hop between two sessions, ours beside bare zenoh: one value written, one read.
//!
//! `cargo bench -p genom-zenoh`. Both wait by looking again and again, so that no wake-up of the
//! reader is counted; what ours has more is the codec and the hand-over to the sending thread.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a program that prints figures"
)]

use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::Instant;

use genom_middleware::{Address, Middleware, Policy, Reading};
use genom_types::{DataType, Kind, Record, TypeTable};
use genom_zenoh::{Options, Zenoh};
use zenoh::qos::CongestionControl;
use zenoh::{Session, Wait};

const ROUNDS: usize = 2000;
const WARM_UP: usize = 200;

fn octets(length: u32) -> DataType {
    let mut table = TypeTable::default();
    let element = table.add(Kind::Octet);
    let id = table.add(Kind::Array { element, length });
    DataType::new(&table.into(), id).unwrap()
}

/// Median and 99th percentile of a round, in microseconds.
fn rounds(mut round: impl FnMut()) -> (f64, f64) {
    let mut times: Vec<f64> = (0..ROUNDS + WARM_UP)
        .map(|_| {
            let start = Instant::now();
            round();
            start.elapsed().as_nanos() as f64 / 1000.0
        })
        .skip(WARM_UP)
        .collect();
    times.sort_by(f64::total_cmp);
    (times[ROUNDS / 2], times[ROUNDS * 99 / 100])
}

/// Bytes, copied in and out, by zenoh alone.
fn bare(a: &Session, b: &Session, bytes: usize) -> (f64, f64) {
    let key = format!("bare/{bytes}");
    let (arrived, place) = (Arc::new(AtomicU64::new(0)), Arc::new(Mutex::new(Vec::new())));
    let (count, into) = (Arc::clone(&arrived), Arc::clone(&place));
    let _subscriber = b
        .declare_subscriber(&key)
        .callback(move |sample| {
            let mut into = into.lock().unwrap();
            into.clear();
            sample.payload().slices().for_each(|part| into.extend_from_slice(part));
            count.fetch_add(1, Ordering::Release);
        })
        .wait()
        .unwrap();
    let publisher = a.declare_publisher(&key).congestion_control(CongestionControl::Block);
    let publisher = publisher.wait().unwrap();
    while !publisher.matching_status().wait().unwrap().matching() {
        thread::yield_now();
    }
    let from = vec![1u8; bytes];
    rounds(|| {
        let before = arrived.load(Ordering::Acquire);
        publisher.put(black_box(&from)).wait().unwrap();
        while arrived.load(Ordering::Acquire) == before {
            thread::yield_now();
        }
        black_box(place.lock().unwrap().len());
    })
}

fn ours(a: &Zenoh, b: &Zenoh, bytes: usize) -> (f64, f64) {
    let ty = octets(bytes as u32);
    let at = Address::new("bench", format!("of{bytes}"));
    let mut writer = a.publisher(&at, &ty).unwrap();
    let mut reader = b.subscription(&at, &ty, Policy::Latest).unwrap();
    let (mut from, mut to) = (Record::new(&ty), Record::new(&ty));
    from.set_bytes(&vec![1u8; bytes]).unwrap();
    rounds(|| {
        writer.publish(black_box(&from)).unwrap();
        while reader.read(&mut to).unwrap() != Reading::New {
            thread::yield_now();
        }
        black_box(&mut to);
    })
}

/// Two sessions with the same options as ours, on a socket of their own.
fn pair(socket: &str) -> (Session, Session) {
    let open = |key: &str, other: &str| {
        let mut config = zenoh::Config::default();
        let endpoint = format!("[\"unixsock-stream/{socket}\"]");
        for (key, value) in [
            (key, endpoint.as_str()),
            (other, "[]"),
            ("scouting/multicast/enabled", "false"),
            ("scouting/gossip/enabled", "false"),
        ] {
            config.insert_json5(key, value).unwrap();
        }
        zenoh::open(config).wait().unwrap()
    };
    let listens = open("listen/endpoints", "connect/endpoints");
    (listens, open("connect/endpoints", "listen/endpoints"))
}

fn main() {
    let place = tempfile::tempdir().unwrap();
    let options = Options { rendezvous: Some(place.path().join("ours")), ..Options::default() };
    let (a, b) = (Zenoh::open(&options).unwrap(), Zenoh::open(&options).unwrap());
    let (bare_a, bare_b) = pair(&place.path().join("bare.sock").display().to_string());
    println!("one hop in us, p50 / p99, over a Unix socket, shared memory where zenoh uses it");
    println!("{:>8} {:>19} {:>19} {:>7} {:>6}", "bytes", "zenoh", "genomd", "+", "x");
    for bytes in [64, 4 << 10, 64 << 10, 1 << 20] {
        let (bare, ours) = (bare(&bare_a, &bare_b, bytes), ours(&a, &b, bytes));
        let show = |(p50, p99): (f64, f64)| format!("{p50:.1} / {p99:.1}");
        println!(
            "{bytes:>8} {:>19} {:>19} {:>7.1} {:>6.2}",
            show(bare),
            show(ours),
            ours.0 - bare.0,
            ours.0 / bare.0,
        );
    }
}
