//! zenoh does not affect real-time threads.

mod world;

use std::io::Read as _;
use std::process::Stdio;

use genom_allocations as allocations;
use genom_conformance::eventually;
use genom_conformance::ports::grown_in_ticks;
use genom_conformance::samples::{note, note_of, number, numbered, state};
use genom_middleware::{Address, Discovery as _, EndpointKind, Policy, PortSpec, Ports, Reading};
use genom_types::Record;
use genom_zenoh::{Options, Zenoh};
use rustix::process::{Pid, Signal, kill_process};
use world::Meeting;

fn position() -> Address {
    Address::new("demo", "position")
}

#[test]
fn writing_and_reading_fixed_types_allocates_nothing() {
    let place = Meeting::new();
    let (a, b) = (place.open(), place.open());
    let mut writer = a.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let policies = [Policy::Latest, Policy::Queue(4), Policy::Ring(4)];
    let mut readers = policies
        .map(|policy| b.subscription(&PortSpec::new(&position(), &state()), policy).unwrap());
    assert_eq!(grown_in_ticks(&mut *writer, &mut readers, allocations::count), 0);
}

#[test]
fn a_stalled_network_holds_up_no_writer_and_the_newest_sample_arrives() {
    let place = Meeting::new();
    let (a, b) = (place.open(), place.open());
    let mut writer = a.publisher(&PortSpec::new(&position(), &state())).unwrap();
    let mut reader =
        b.subscription(&PortSpec::new(&position(), &state()), Policy::Ring(64)).unwrap();
    let mut got = Record::new(&state());
    writer.publish(&numbered(1)).unwrap();
    eventually("they are connected", || reader.read(&mut got).unwrap() == Reading::New);

    let stalled = a.stall();
    // Returns although nothing is sent; otherwise the test hangs here.
    for n in 2..=1000 {
        writer.publish(&numbered(n)).unwrap();
    }
    let kept = 999 - writer.dropped();
    assert!((1..100).contains(&kept), "{kept} samples wait");
    assert_eq!(reader.read(&mut got), Ok(Reading::Same));
    drop(stalled);
    let mut read = Vec::new();
    eventually("the newest arrives", || {
        if reader.read(&mut got).unwrap() == Reading::New {
            read.push(number(&got));
        }
        read.last() == Some(&1000)
    });
    assert_eq!(read.len() as u64, kept, "what was not dropped arrived");
}

fn notes() -> Address {
    Address::new("demo", "note")
}

/// Environment variable with the rendezvous folder of the process that is stopped.
const PLACE: &str = "GENOM_ZENOH_READER_PLACE";

#[test]
#[ignore = "is another process, which the next test starts"]
fn reads_until_it_is_stopped() {
    let Some(place) = std::env::var_os(PLACE) else { return };
    let options = Options { rendezvous: Some(place.into()), ..Options::default() };
    let zenoh = Zenoh::open(&options).unwrap();
    let reader = zenoh.subscription(&PortSpec::new(&notes(), &note()), Policy::Ring(4));
    // Ends with the test if it is not killed before.
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
    drop(reader);
}

#[test]
fn a_reader_that_stopped_holds_up_its_own_port_and_no_other() {
    let place = Meeting::new();
    let (a, b) = (place.open(), place.open());
    let mut noisy = a.publisher(&PortSpec::new(&notes(), &note())).unwrap();
    let port = (position(), state());
    let port = PortSpec::new(&port.0, &port.1);
    let mut other = a.publisher(&port).unwrap();
    let mut reader = b.subscription(&port, Policy::Latest).unwrap();
    let mut got = Record::new(&state());
    other.publish(&numbered(1)).unwrap();
    eventually("they are connected", || reader.read(&mut got).unwrap() == Reading::New);
    let mut stopped = genom_conformance::again("reads_until_it_is_stopped")
        .env(PLACE, place.options().rendezvous.unwrap())
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let shows = || {
        let seen = a.discover().unwrap();
        seen.iter()
            .any(|end| end.kind == EndpointKind::Subscription && end.address == notes().to_string())
    };
    eventually("it reads", shows);
    kill_process(Pid::from_child(&stopped), Signal::STOP).unwrap();

    // About 2 KB each: larger ones are sent in shared memory, which does not block.
    let mut value = Record::new(&note());
    value.merge_json(&note_of(80)).unwrap();
    // Blocked: nothing is taken from its mailbox, which is full, so each sample written drops one.
    let (mut n, mut in_a_row) = (1, 0);
    eventually("the other port goes on while the first one is held up", || {
        let before = noisy.dropped();
        (0..8).for_each(|_| noisy.publish(&value).unwrap());
        n += 1;
        other.publish(&numbered(n)).unwrap();
        eventually("its sample arrives", || {
            reader.read(&mut got).unwrap() == Reading::New && number(&got) == n
        });
        (0..8).for_each(|_| noisy.publish(&value).unwrap());
        in_a_row = if noisy.dropped() - before == 16 { in_a_row + 1 } else { 0 };
        in_a_row == 10
    });
    stopped.kill().unwrap();
    stopped.wait().unwrap();
}
