//! Killed processes leave nothing behind that blocks others.

mod world;

use std::time::Duration;

use genom_conformance::samples::{note, number, numbered, other_state, state};
use genom_conformance::{World, eventually};
use genom_middleware::reply::{Reply, pair};
use genom_middleware::{
    Address, CallError, Policy, PortSpec, Ports, Reading, ServiceKind, ServiceType, Services,
    Subscription,
};
use genom_types::Record;

use world::ShmWorld;
use world::process::Process;

/// Reached only by a test that fails.
const WATCHDOG: Duration = Duration::from_secs(60);

fn position() -> Address {
    Address::new("demo", "position")
}

#[track_caller]
fn read_until(reader: &mut dyn Subscription, wanted: u64) {
    let mut got = Record::new(&state());
    eventually("the sample arrives", || {
        reader.read(&mut got) == Ok(Reading::New) && number(&got) == wanted
    });
}

fn start(world: &ShmWorld) -> Process {
    let process = Process::writer(world);
    assert_eq!(process.says(), "ready");
    process
}

#[test]
#[ignore = "is another process, which the other tests start"]
fn writes_until_it_is_killed() {
    world::writer::run();
}

#[test]
fn a_killed_writer_comes_back_and_its_readers_go_on() {
    let world = ShmWorld::new();
    let shm = world.open();
    let policies = [Policy::Latest, Policy::Queue(3), Policy::Ring(3)];
    let mut readers = policies
        .map(|policy| shm.subscription(&PortSpec::new(&position(), &state()), policy).unwrap());
    for round in 1..4 {
        let mut process = start(&world);
        process.tell(&round.to_string());
        assert_eq!(process.says(), "sent");
        for reader in &mut readers {
            read_until(&mut **reader, round);
        }
        process.kill();
    }
}

#[test]
fn the_address_of_a_killed_writer_is_free_for_another_process_and_another_type() {
    let world = ShmWorld::new();
    let shm = world.open();
    let process = start(&world);
    assert!(shm.publisher(&PortSpec::new(&position(), &state())).is_err());
    process.kill();
    drop(
        shm.publisher(&PortSpec::new(&position(), &other_state()))
            .expect("free, also for another type"),
    );
    drop(shm.publisher(&PortSpec::new(&Address::new("demo", "note"), &state())).expect("free"));
}

#[test]
fn a_killed_reader_takes_nothing_from_the_writer() {
    let world = ShmWorld::new();
    let shm = world.open();
    let parameter = Address::new("demo", "parameter");
    let mut writer = shm.publisher(&PortSpec::new(&parameter, &state())).unwrap();
    for round in 0..3 {
        let process = start(&world);
        let mut reader =
            shm.subscription(&PortSpec::new(&parameter, &state()), Policy::Latest).unwrap();
        for n in 1..200 {
            writer.publish(&numbered(round * 1000 + n)).unwrap();
            read_until(&mut *reader, round * 1000 + n);
        }
        process.kill();
        for n in 200..400 {
            writer.publish(&numbered(round * 1000 + n)).unwrap();
            read_until(&mut *reader, round * 1000 + n);
        }
    }
    assert_eq!(writer.dropped(), 0);
}

#[test]
fn what_a_killed_process_leaves_is_removed_by_the_next_start() {
    let world = ShmWorld::new();
    let process = start(&world);
    assert!(!world.leftovers().is_empty());
    process.kill();
    assert!(!world.leftovers().is_empty(), "a killed process cannot clean up");
    drop(world.open());
    assert_eq!(world.leftovers(), Vec::<String>::new());
}

#[test]
fn another_process_sees_the_last_value_of_every_kind() {
    let world = ShmWorld::new();
    let mut process = start(&world);
    process.tell("77");
    assert_eq!(process.says(), "sent");
    let shm = world.open();
    read_until(
        &mut *shm.subscription(&PortSpec::new(&position(), &state()), Policy::Queue(2)).unwrap(),
        77,
    );
    let at = Address::new("demo", "note");
    let mut notes = shm.subscription(&PortSpec::new(&at, &note()), Policy::Latest).unwrap();
    let mut got = Record::new(&note());
    eventually("the note arrives", || notes.read(&mut got) == Ok(Reading::New));
    assert_eq!(got.to_json()["rows"].as_array().map(Vec::len), Some(5));
    process.end();
}

#[test]
fn the_caller_of_a_killed_service_is_told() {
    let world = ShmWorld::new();
    let shm = world.open();
    let goto = ServiceType::new(ServiceKind::Activity, state(), state());
    let mut client = shm.client(&Address::new("demo", "goto"), &goto).unwrap();
    for _ in 0..2 {
        let process = start(&world);
        let (replies, reply) = pair();
        let _running = client.request(&numbered(1), Box::new(replies)).unwrap();
        assert!(matches!(reply.next(WATCHDOG), Ok(Reply::Accepted(_))));
        process.kill();
        assert_eq!(reply.wait(WATCHDOG).err(), Some(CallError::Gone));
    }
}
