//! What ports cost on YARP: opening and closing, memory and descriptors of 1, 50 and 500 pairs, and
//! a hop between two ends beside one over a bare socket. `cargo bench -p genom-yarp`.

#![allow(
    missing_docs,
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a program that measures and prints"
)]

#[path = "../tests/world/mod.rs"]
mod world;

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use genom_conformance::ports::read_until;
use genom_conformance::process::{resident, used};
use genom_conformance::samples::{numbered, set_number, state};
use genom_middleware::{Address, Policy, PortSpec, Ports as _, Reading};
use genom_types::Record;
use world::Place;

fn pairs(count: usize) {
    let place = Place::new();
    let (a, b) = (place.open(), place.open());
    let ty = state();
    let (memory, (files, _)) = (resident(), used());
    let begun = Instant::now();
    let mut ends: Vec<_> = (0..count)
        .map(|n| {
            let at = Address::new("demo", format!("port{n}"));
            let port = PortSpec::new(&at, &ty);
            (a.publisher(&port).unwrap(), b.subscription(&port, Policy::Latest).unwrap())
        })
        .collect();
    let opened = begun.elapsed();
    for (n, (writer, reader)) in ends.iter_mut().enumerate() {
        writer.publish(&numbered(n as u64)).unwrap();
        read_until(&mut **reader, n as u64);
    }
    let flowing = begun.elapsed();
    let (more, (descriptors, threads)) = (resident() - memory, used());
    let descriptors = descriptors - files;
    let begun = Instant::now();
    drop(ends);
    println!(
        "{count:>4} pairs: opened {opened:>8.1?}, all read after {flowing:>8.1?}, closed \
         {:>8.1?}; {more} kB, {descriptors} descriptors, {threads} threads",
        begun.elapsed()
    );
}

fn printed(what: &str, mut times: Vec<Duration>) {
    times.sort_unstable();
    let at = |per_mille: usize| times[times.len() * per_mille / 1000];
    println!("{what}: p50 {:.1?}, p99 {:.1?}", at(500), at(990));
}

const HOPS: u64 = 5000;

fn hop() {
    let place = Place::new();
    let (a, b) = (place.open(), place.open());
    let (at, ty) = (Address::new("demo", "position"), state());
    let port = PortSpec::new(&at, &ty);
    let mut writer = a.publisher(&port).unwrap();
    let mut reader = b.subscription(&port, Policy::Latest).unwrap();
    let (arrived, arrives) = std::sync::mpsc::channel();
    reader.on_arrival(Box::new(move || arrived.send(Instant::now()).unwrap()));
    let (mut sent, mut got) = (numbered(0), Record::new(&ty));
    let mut times = Vec::new();
    for n in 1..=HOPS {
        set_number(&mut sent, n);
        let begun = Instant::now();
        writer.publish(&sent).unwrap();
        let came = arrives.recv().unwrap();
        times.push(came.saturating_duration_since(begun));
        assert_eq!(reader.read(&mut got), Ok(Reading::New));
    }
    printed("a port, 64 bytes, write to arrival", times);
}

fn bare() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let mut writer = TcpStream::connect(listener.local_addr().unwrap()).unwrap();
    writer.set_nodelay(true).unwrap();
    let (mut reader, _) = listener.accept().unwrap();
    let (arrived, arrives) = std::sync::mpsc::channel();
    let reading = thread::spawn(move || {
        let mut sample = [0; 150];
        while reader.read_exact(&mut sample).is_ok() {
            arrived.send(Instant::now()).unwrap();
        }
    });
    let mut times = Vec::new();
    for _ in 0..HOPS {
        let begun = Instant::now();
        writer.write_all(&[1; 150]).unwrap();
        let came: Instant = arrives.recv().unwrap();
        times.push(came.saturating_duration_since(begun));
    }
    drop(writer);
    reading.join().unwrap();
    printed("a bare socket, 150 bytes as there", times);
}

fn main() {
    [1, 50, 500].into_iter().for_each(pairs);
    hop();
    bare();
}
