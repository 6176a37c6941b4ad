//! Reading and writing: last value, policies, order.

use std::sync::Arc;
use std::thread;

use genom_types::Record;

use crate::harness::{World, eventually};
use crate::samples::{number, numbered, set_number, state};
use genom_middleware::{Address, Middleware, Policy, PortSpec, Publisher, Reading, Subscription};

/// The address that most properties use.
#[must_use]
pub fn position() -> Address {
    Address::new("demo", "position")
}

/// Opens an out port there.
///
/// # Panics
/// When it is refused.
#[must_use]
pub fn writer(on: &Arc<dyn Middleware>) -> Box<dyn Publisher> {
    on.publisher(&PortSpec::new(&position(), &state())).expect("an out port")
}

/// Opens an in port there.
///
/// # Panics
/// When it is refused.
#[must_use]
pub fn reader(on: &Arc<dyn Middleware>, policy: Policy) -> Box<dyn Subscription> {
    on.subscription(&PortSpec::new(&position(), &state()), policy).expect("an in port")
}

/// Number in a record before it is read into.
const UNTOUCHED: u64 = 1 << 40;

/// Reads once, and checks that the record is unchanged if nothing new was read.
#[track_caller]
pub(super) fn read(from: &mut dyn Subscription) -> (Reading, u64) {
    let mut record = numbered(UNTOUCHED);
    let reading = from.read(&mut record).expect("a reading");
    let number = number(&record);
    assert_eq!(reading == Reading::New, number != UNTOUCHED, "{reading:?} but {number}");
    (reading, number)
}

/// Reads until this number arrives.
///
/// # Panics
/// When it does not.
#[track_caller]
pub fn read_until(from: &mut dyn Subscription, wanted: u64) {
    let mut seen = Vec::new();
    eventually("the sample arrives", || {
        let (reading, number) = read(from);
        if reading == Reading::New {
            seen.push(number);
        }
        seen.last() == Some(&wanted)
    });
}

/// Publishes 0, then 1, and reads both. Afterwards no other sample is in transit between the two.
///
/// Each is published once, whichever end was opened first: a late reader gets the last value.
#[track_caller]
pub(super) fn connect(writer: &mut dyn Publisher, reader: &mut dyn Subscription) {
    for n in [0, 1] {
        writer.publish(&numbered(n)).expect("published");
        read_until(reader, n);
    }
}

/// Writes samples and reads each by all readers, as ticks do. Returns by how much `count`, such as
/// the number of allocations of this thread, grew in calls of the ends.
///
/// # Panics
/// A call of an end fails, or a sample does not arrive.
pub fn grown_in_ticks(
    writer: &mut dyn Publisher,
    readers: &mut [Box<dyn Subscription>],
    count: impl Fn() -> u64,
) -> u64 {
    let (mut sent, mut got) = (numbered(0), Record::new(&state()));
    let mut counted = 0;
    for n in 1..200 {
        set_number(&mut sent, n);
        let before = count();
        writer.publish(&sent).unwrap();
        counted += count() - before;
        for reader in &mut *readers {
            eventually("the sample arrives", || {
                let before = count();
                let reading = reader.read(&mut got).unwrap();
                counted += count() - before;
                reading == Reading::New && number(&got) == n
            });
        }
        // The first round allocates what the thread itself needs.
        if n == 1 {
            counted = 0;
        }
    }
    counted
}

/// A reader gets what was written, once.
pub fn a_reader_sees_what_was_written(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let (mut writer, mut reader) = (writer(&a), reader(&b, Policy::Latest));
    connect(&mut *writer, &mut *reader);
    for n in 2..50 {
        writer.publish(&numbered(n)).unwrap();
        read_until(&mut *reader, n);
        assert_eq!(read(&mut *reader).0, Reading::Same);
    }
    assert_eq!((writer.dropped(), reader.dropped()), (0, 0));
}

/// Readers opened later get the last value, although the writer does nothing more.
pub fn a_late_reader_sees_the_last_value(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let mut writer = writer(&a);
    for n in 0..20 {
        writer.publish(&numbered(n)).unwrap();
    }
    for policy in [Policy::Latest, Policy::Queue(4), Policy::Ring(4), Policy::Latest] {
        let mut late = reader(&b, policy);
        read_until(&mut *late, 19);
        assert_eq!(read(&mut *late).0, Reading::Same);
        assert_eq!(late.dropped(), 0, "what came before a reader is no loss of it");
    }
}

/// A reader may be opened before its writer.
pub fn a_reader_may_come_before_its_writer(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let mut readers = [Policy::Latest, Policy::Queue(4), Policy::Ring(4)].map(|p| reader(&b, p));
    for reader in &mut readers {
        assert_eq!(read(&mut **reader).0, Reading::Never);
    }
    let mut writer = writer(&a);
    writer.publish(&numbered(7)).unwrap();
    for reader in &mut readers {
        read_until(&mut **reader, 7);
    }
}

/// genom3.md 7.8: reading a connected port that was never written is not an error.
pub fn nothing_is_read_before_the_first_write(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let writer = writer(&a);
    let mut reader = reader(&b, Policy::Latest);
    for _ in 0..10 {
        assert_eq!(read(&mut *reader).0, Reading::Never);
    }
    drop(writer);
    assert_eq!(read(&mut *reader).0, Reading::Never);
}

/// genom3.md 7.8: no queue, only the last value.
pub fn latest_skips_to_the_newest(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let (mut writer, mut reader) = (writer(&a), reader(&b, Policy::Latest));
    connect(&mut *writer, &mut *reader);
    let mut previous = 1;
    for round in 1..=20 {
        let newest = round * 100;
        for n in newest - 50..=newest {
            writer.publish(&numbered(n)).unwrap();
        }
        eventually("the newest is read", || {
            let (reading, n) = read(&mut *reader);
            if reading == Reading::New {
                assert!(n > previous, "{n} after {previous}");
                previous = n;
            }
            previous == newest
        });
    }
    assert_eq!(reader.dropped(), 0, "skipping is what `latest` asks for");
}

/// Publishes `count` samples after [`connect`], and waits until the reader's side holds or has
/// dropped all of them.
///
/// `witness` is a second reader of the same policy with a sufficient depth; it shows that all
/// samples arrived.
fn publish_all(writer: &mut dyn Publisher, witness: &mut dyn Subscription, count: u64) {
    for n in 2..2 + count {
        writer.publish(&numbered(n)).unwrap();
        // The witness keeps up, so slow middlewares, too, have delivered to all readers then.
        read_until(witness, n);
    }
}

/// A full queue drops new samples.
pub fn a_queue_keeps_the_oldest_and_counts_the_rest(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let mut writer = writer(&a);
    let (mut queue, mut witness) = (reader(&b, Policy::Queue(3)), reader(&b, Policy::Latest));
    connect(&mut *writer, &mut *queue);
    publish_all(&mut *writer, &mut *witness, 10);
    for expected in [2, 3, 4] {
        read_until(&mut *queue, expected);
    }
    assert_eq!(read(&mut *queue).0, Reading::Same);
    eventually("the 7 others are counted", || {
        assert_eq!(read(&mut *queue).0, Reading::Same);
        queue.dropped() == 7
    });
    writer.publish(&numbered(90)).unwrap();
    read_until(&mut *queue, 90);
    assert_eq!(queue.dropped(), 7);
}

/// A full ring overwrites the oldest sample.
pub fn a_ring_keeps_the_newest_and_counts_the_rest(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let mut writer = writer(&a);
    let (mut ring, mut witness) = (reader(&b, Policy::Ring(3)), reader(&b, Policy::Latest));
    connect(&mut *writer, &mut *ring);
    publish_all(&mut *writer, &mut *witness, 10);
    for expected in [9, 10, 11] {
        assert_eq!(read(&mut *ring), (Reading::New, expected));
    }
    assert_eq!(read(&mut *ring).0, Reading::Same);
    assert_eq!(ring.dropped(), 7);
    writer.publish(&numbered(90)).unwrap();
    read_until(&mut *ring, 90);
    assert_eq!(ring.dropped(), 7);
}

/// However often a reader reads, samples that it did not get were counted as lost.
pub fn every_sample_is_read_or_counted(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    for (port, policy) in [("ring", Policy::Ring(4)), ("queue", Policy::Queue(4))] {
        let at = Address::new("demo", port);
        let mut writer = a.publisher(&PortSpec::new(&at, &state())).expect("an out port");
        let open =
            |policy| b.subscription(&PortSpec::new(&at, &state()), policy).expect("an in port");
        let (mut reader, mut witness) = (open(policy), open(Policy::Latest));
        connect(&mut *writer, &mut *reader);
        let (mut written, mut seen) = (0, 0);
        for (burst, reads) in [(3, 1), (9, 2), (1, 5), (20, 0), (4, 4), (2, 1), (13, 3), (30, 0)] {
            for n in written..written + burst {
                writer.publish(&numbered(n + 2)).unwrap();
                read_until(&mut *witness, n + 2);
            }
            written += burst;
            let found = (0..reads).map(|_| read(&mut *reader).0);
            seen += found.filter(|reading| *reading == Reading::New).count() as u64;
        }
        // Samples after its last read are lost as well, or still unread.
        eventually("all is read or counted", || {
            seen += u64::from(read(&mut *reader).0 == Reading::New);
            seen + reader.dropped() == written
        });
        assert_eq!(read(&mut *reader).0, Reading::Same);
        assert_eq!(seen + reader.dropped(), written, "{port}");
    }
}

/// However fast samples are written, and whoever joins meanwhile: those that a reader does not get
/// are counted, by it or by the writer.
pub fn a_burst_is_read_or_counted(world: &dyn World) {
    const WRITTEN: u64 = 20_000;
    let (a, b) = (world.join(), world.join());
    let mut writer = writer(&a);
    let mut reader = reader(&b, Policy::Ring(4));
    connect(&mut *writer, &mut *reader);
    let mut late = Vec::new();
    let mut seen = 0;
    for n in 0..WRITTEN {
        writer.publish(&numbered(n + 2)).unwrap();
        if n % 4_000 == 2_000 {
            late.push(self::reader(&b, Policy::Latest));
        }
        if n % 16 == 0 {
            seen += u64::from(read(&mut *reader).0 == Reading::New);
        }
    }
    eventually("all is read or counted", || {
        seen += u64::from(read(&mut *reader).0 == Reading::New);
        seen + reader.dropped() + writer.dropped() >= WRITTEN
    });
    for last in &mut late {
        read_until(&mut **last, WRITTEN + 1);
    }
    while read(&mut *reader).0 == Reading::New {
        seen += 1;
    }
    assert_eq!(seen + reader.dropped() + writer.dropped(), WRITTEN);
}

/// A reader that does not read does not affect the others.
pub fn readers_go_at_their_own_pace(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let mut writer = writer(&a);
    let mut asleep = reader(&b, Policy::Queue(2));
    let mut awake: Vec<_> = (0..4).map(|_| reader(&b, Policy::Ring(8))).collect();
    connect(&mut *writer, &mut *asleep);
    for reader in &mut awake {
        read_until(&mut **reader, 1);
    }
    for n in 2..300 {
        writer.publish(&numbered(n)).unwrap();
        for reader in &mut awake {
            read_until(&mut **reader, n);
        }
    }
    assert_eq!(read(&mut *asleep), (Reading::New, 2));
    assert!(awake.iter().all(|reader| reader.dropped() == 0));
}

/// Under load from another thread: no sample twice, out of order or torn, and the last one arrives.
pub fn samples_arrive_in_order(world: &dyn World) {
    const LAST: u64 = 20_000;
    let (a, b) = (world.join(), world.join());
    let mut writer = writer(&a);
    let policies = [Policy::Latest, Policy::Ring(8), Policy::Latest];
    let mut readers = policies.map(|policy| reader(&b, policy));
    for reader in &mut readers {
        connect(&mut *writer, &mut **reader);
    }
    let writing = thread::spawn(move || {
        let mut record = numbered(0);
        for n in 2..=LAST {
            set_number(&mut record, n);
            writer.publish(&record).unwrap();
        }
        writer
    });
    thread::scope(|scope| {
        for mut reader in readers {
            scope.spawn(move || {
                let mut record = Record::new(&state());
                let mut previous = 0;
                eventually("the last sample comes", || {
                    // Many reads per check of the clock.
                    for _ in 0..1000 {
                        if reader.read(&mut record).unwrap() == Reading::New {
                            let n = number(&record);
                            // 1 may arrive again, sent for a later reader.
                            assert!(n > previous || n <= 1, "{n} after {previous}");
                            previous = n;
                        }
                    }
                    previous == LAST
                });
            });
        }
    });
    drop(writing.join().unwrap());
}

/// Each address has its own values.
pub fn many_ports_do_not_mix(world: &dyn World) {
    const PORTS: u64 = 64;
    let (a, b) = (world.join(), world.join());
    let at = |n: u64| Address::new(format!("robot{}", n % 8), format!("port{n}"));
    let mut ports: Vec<_> = (0..PORTS)
        .map(|n| {
            let writer = a.publisher(&PortSpec::new(&at(n), &state())).unwrap();
            (n, writer, b.subscription(&PortSpec::new(&at(n), &state()), Policy::Latest).unwrap())
        })
        .collect();
    for (n, writer, _) in &mut ports {
        writer.publish(&numbered(*n + 1000)).unwrap();
    }
    for (n, _, reader) in &mut ports {
        read_until(&mut **reader, *n + 1000);
    }
}

/// `<instance>/<port>/<element>` is an address of its own (genom3.md 7.8).
pub fn elements_of_a_multiple_port_are_apart(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let names = ["poses", "poses/left", "poses/right", "poses/far.left"];
    let mut ends = names.map(|name| {
        let at = Address::new("demo", name);
        let writer = a.publisher(&PortSpec::new(&at, &state())).unwrap();
        (writer, b.subscription(&PortSpec::new(&at, &state()), Policy::Latest).unwrap())
    });
    for (n, (writer, _)) in ends.iter_mut().enumerate() {
        writer.publish(&numbered(n as u64 + 10)).unwrap();
    }
    for (n, (_, reader)) in ends.iter_mut().enumerate() {
        read_until(&mut **reader, n as u64 + 10);
    }
}
