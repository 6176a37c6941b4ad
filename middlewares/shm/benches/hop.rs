//! A hop over shared memory, ours beside bare iceoryx2: one value written, one read.
//!
//! `cargo bench -p genom-shm`

#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a program that prints figures"
)]

use std::hint::black_box;
use std::time::Instant;

use genom_middleware::{Address, Middleware, Policy, Reading};
use genom_shm::{Options, Shm};
use genom_types::{DataType, Kind, Record, TypeTable};
use iceoryx2::prelude::*;

const BATCHES: usize = 200;

/// An array, or an unbounded sequence, of octets.
fn octets(length: u32, sequence: bool) -> DataType {
    let mut table = TypeTable::default();
    let element = table.add(Kind::Octet);
    let id = table.add(if sequence {
        Kind::Sequence { element, bound: None }
    } else {
        Kind::Array { element, length }
    });
    DataType::new(&table.into(), id).unwrap()
}

/// Median and 99th percentile of a round, in ns.
fn rounds(bytes: usize, mut round: impl FnMut()) -> (f64, f64) {
    let batch = (200_000 / bytes.max(64)).max(1);
    let mut times: Vec<f64> = (0..BATCHES + 20)
        .map(|_| {
            let start = Instant::now();
            (0..batch).for_each(|_| round());
            start.elapsed().as_nanos() as f64 / batch as f64
        })
        .skip(20)
        .collect();
    times.sort_by(f64::total_cmp);
    (times[BATCHES / 2], times[BATCHES * 99 / 100])
}

/// Slices, copied in and out, by iceoryx2 alone.
fn bare(node: &Node<ipc_threadsafe::Service>, bytes: usize) -> (f64, f64) {
    let name = ServiceName::new(&format!("bare/{bytes}")).unwrap();
    let service = node.service_builder(&name).publish_subscribe::<[u8]>().create().unwrap();
    let writer = service.publisher_builder().initial_max_slice_len(bytes).create().unwrap();
    let reader = service.subscriber_builder().create().unwrap();
    let (from, mut to) = (vec![1u8; bytes], vec![0u8; bytes]);
    rounds(bytes, || {
        let sample = writer.loan_slice_uninit(bytes).unwrap();
        sample.write_from_slice(black_box(&from)).send().unwrap();
        to.copy_from_slice(reader.receive().unwrap().unwrap().payload());
        black_box(&mut to);
    })
}

fn ours(shm: &Shm, bytes: usize, sequence: bool) -> (f64, f64) {
    let ty = octets(bytes as u32, sequence);
    let at = Address::new("bench", format!("{bytes}{sequence}"));
    let mut writer = shm.publisher(&at, &ty).unwrap();
    let mut reader = shm.subscription(&at, &ty, Policy::Latest).unwrap();
    let (mut from, mut to) = (Record::new(&ty), Record::new(&ty));
    if sequence {
        from.merge_json(&vec![1u8; bytes].into()).unwrap();
    } else {
        from.set_bytes(&vec![1u8; bytes]).unwrap();
    }
    rounds(bytes, || {
        writer.publish(black_box(&from)).unwrap();
        assert_eq!(reader.read(&mut to), Ok(Reading::New));
        black_box(&mut to);
    })
}

fn main() {
    let root = std::env::temp_dir().join(format!("genombench_{}", std::process::id()));
    let options = Options {
        prefix: Some(format!("genombench_{}_", std::process::id())),
        root: Some(root.clone()),
        ..Options::default()
    };
    let shm = Shm::open(options).unwrap();
    let mut config = Config::default();
    config.global.prefix = FileName::new(b"genombench_bare_").unwrap();
    let node = NodeBuilder::new().config(&config).create::<ipc_threadsafe::Service>().unwrap();
    println!("one hop in ns, p50 / p99; copies in and out included on both sides");
    println!(
        "{:>8} {:>19} {:>19} {:>6} {:>19} {:>6}",
        "bytes", "iceoryx2", "fixed", "x", "CDR", "x"
    );
    for bytes in [64, 4 << 10, 64 << 10, 1 << 20] {
        let (bare, fixed, cdr) =
            (bare(&node, bytes), ours(&shm, bytes, false), ours(&shm, bytes, true));
        let show = |(p50, p99): (f64, f64)| format!("{p50:.0} / {p99:.0}");
        println!(
            "{bytes:>8} {:>19} {:>19} {:>6.2} {:>19} {:>6.2}",
            show(bare),
            show(fixed),
            fixed.0 / bare.0,
            show(cdr),
            cdr.0 / bare.0,
        );
    }
    drop(shm);
    let _ = std::fs::remove_dir_all(root);
}
