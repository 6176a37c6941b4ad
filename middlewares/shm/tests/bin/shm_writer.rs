//! A process of ours that writes ports over shared memory until it is killed.
//!
//! `shm-writer PREFIX ROOT` publishes the numbers it reads on `demo/position`, and a note.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program of the tests")]

use std::io::BufRead;

use genom_middleware::conformance::samples::{note, note_of, numbered, state};
use genom_middleware::{Address, Middleware, Policy};
use genom_shm::{Options, Shm};
use genom_types::Record;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [prefix, root] = arguments.as_slice() else {
        println!("usage: PREFIX ROOT");
        return;
    };
    let options =
        Options { prefix: Some(prefix.clone()), root: Some(root.into()), ..Options::default() };
    let shm = Shm::open(options).unwrap();
    let mut writer = shm.publisher(&Address::new("demo", "position"), &state()).unwrap();
    let mut notes = shm.publisher(&Address::new("demo", "note"), &note()).unwrap();
    let _reader =
        shm.subscription(&Address::new("demo", "parameter"), &state(), Policy::Queue(4)).unwrap();
    let mut value = Record::new(&note());
    value.merge_json(&note_of(5)).unwrap();
    notes.publish(&value).unwrap();
    println!("ready");
    for line in std::io::stdin().lock().lines() {
        writer.publish(&numbered(line.unwrap().parse().unwrap())).unwrap();
        println!("sent");
    }
}
