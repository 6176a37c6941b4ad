//! A process of ours that writes ports over shared memory until it is killed.

use std::io::BufRead;
use std::sync::{Arc, Mutex};

use genom_conformance::samples::{note, note_of, numbered, state};
use genom_middleware::{
    ActivityId, Address, Policy, PortSpec, Ports, Replies, ServiceHandler, ServiceKind,
    ServiceType, Services,
};
use genom_shm::{Options, Shm};
use genom_types::Record;

use super::process::{MARK, PREFIX, ROOT};

/// Accepts a request and never finishes it.
#[derive(Default)]
struct Endless(Mutex<Vec<Box<dyn Replies>>>);

impl ServiceHandler for Endless {
    fn request(&self, _: Record, mut replies: Box<dyn Replies>) {
        replies.accepted(ActivityId(1));
        self.0.lock().unwrap().push(replies);
    }

    fn cancel(&self, _: ActivityId) {}
}

/// Publishes the numbers it reads on `demo/position`, and a note; serves the activity `demo/goto`,
/// which never ends. Does nothing unless it was started by [`Process::writer`].
///
/// [`Process::writer`]: super::process::Process::writer
pub(crate) fn run() {
    let (Ok(prefix), Some(root)) = (std::env::var(PREFIX), std::env::var_os(ROOT)) else { return };
    let options = Options { prefix: Some(prefix), root: Some(root.into()), ..Options::default() };
    let shm = Shm::open(options).unwrap();
    let mut writer =
        shm.publisher(&PortSpec::new(&Address::new("demo", "position"), &state())).unwrap();
    let mut notes = shm.publisher(&PortSpec::new(&Address::new("demo", "note"), &note())).unwrap();
    let _reader = shm
        .subscription(
            &PortSpec::new(&Address::new("demo", "parameter"), &state()),
            Policy::Queue(4),
        )
        .unwrap();
    let mut value = Record::new(&note());
    value.merge_json(&note_of(5)).unwrap();
    notes.publish(&value).unwrap();
    let goto = ServiceType::new(ServiceKind::Activity, state(), state());
    let handler = Arc::new(Endless::default());
    let _served = shm.serve(&Address::new("demo", "goto"), &goto, handler).unwrap();
    println!("{MARK}ready");
    for line in std::io::stdin().lock().lines() {
        writer.publish(&numbered(line.unwrap().parse().unwrap())).unwrap();
        println!("{MARK}sent");
    }
}
