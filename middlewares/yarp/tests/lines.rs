//! Who floods a port does not flood the log.

#![allow(clippy::unwrap_used, reason = "test code outside of test functions")]

mod attack;
mod world;

use std::fmt::Debug;
use std::io::Write as _;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use attack::{NO_YARP, Pair, ends, hello, message};
use genom_conformance::{World, eventually};
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id, Record};
use tracing::{Event, Level, Metadata, Subscriber};

/// The lines of this process from level `info` on.
static LINES: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Log;

impl Subscriber for Log {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.is_event() && *metadata.level() <= Level::INFO
    }

    fn new_span(&self, _: &Attributes<'_>) -> Id {
        Id::from_u64(1)
    }

    fn record(&self, _: &Id, _: &Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, event: &Event<'_>) {
        let mut line = Line(String::new());
        event.record(&mut line);
        LINES.lock().unwrap_or_else(PoisonError::into_inner).push(line.0);
    }

    fn enter(&self, _: &Id) {}

    fn exit(&self, _: &Id) {}
}

struct Line(String);

impl Visit for Line {
    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        self.0.push_str(&format!("{}={value:?} ", field.name()));
    }
}

/// The number of lines that contain these words.
fn lines(words: &str) -> usize {
    let lines = LINES.lock().unwrap_or_else(PoisonError::into_inner);
    lines.iter().filter(|line| line.contains(words)).count()
}

#[test]
fn a_flood_writes_few_lines_and_hides_no_other_reason() {
    tracing::subscriber::set_global_default(Log).unwrap();
    let mut pair = Pair::new(World::join);
    let (started, attacks) = (Instant::now(), 400);
    // Peers that say who they are and go, and some that speak no YARP.
    for count in 1..=attacks {
        let mut stream = pair.dial();
        stream.write_all(&hello()).unwrap();
        drop(stream);
        let mut stream = pair.dial();
        let _ = stream.write_all(b"GET / HTTP/1.1\r\n\r\n");
        assert!(ends(&mut stream));
        eventually("it is counted", || pair.refused(NO_YARP) == count);
    }
    // Another reason has its line at once.
    let why = "a bottle that is no sample of its port's type";
    let mut stream = pair.dial();
    stream.write_all(&[hello(), message(&[])].concat()).unwrap();
    eventually("it is counted", || pair.refused(why) == 1);
    eventually("it is told", || lines(why) == 1);
    pair.works();
    let seconds = 2 + started.elapsed().as_secs() as usize;
    assert!(lines(NO_YARP) <= seconds, "{} in {seconds} s", lines(NO_YARP));
    let ended = lines("a YARP connection ended");
    assert!(ended >= 30 && ended <= 64 + seconds, "{ended} in {seconds} s");
}
