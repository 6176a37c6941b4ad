//! A process of ours that writes ports over shared memory until it is killed.
//!
//! `shm-writer PREFIX ROOT` publishes the numbers it reads on `demo/position`, and a note. It
//! serves the activity `demo/goto`, which never ends.

#![allow(clippy::print_stdout, clippy::unwrap_used, reason = "a program of the tests")]

use std::io::BufRead;
use std::sync::{Arc, Mutex};

use genom_middleware::conformance::samples::{note, note_of, numbered, state};
use genom_middleware::{
    ActivityId, Address, Middleware, Policy, Replies, ServiceHandler, ServiceKind, ServiceType,
};
use genom_shm::{Options, Shm};
use genom_types::Record;

/// Accepts, and keeps the request for good.
#[derive(Default)]
struct Endless(Mutex<Vec<Box<dyn Replies>>>);

impl ServiceHandler for Endless {
    fn request(&self, _: Record, mut replies: Box<dyn Replies>) {
        replies.accepted(ActivityId(1));
        self.0.lock().unwrap().push(replies);
    }

    fn cancel(&self, _: ActivityId) {}
}

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
    let goto = ServiceType::new(ServiceKind::Activity, state(), state());
    let handler = Arc::new(Endless::default());
    let _served = shm.serve(&Address::new("demo", "goto"), &goto, handler).unwrap();
    println!("ready");
    for line in std::io::stdin().lock().lines() {
        writer.publish(&numbered(line.unwrap().parse().unwrap())).unwrap();
        println!("sent");
    }
}
