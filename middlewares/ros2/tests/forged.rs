//! Forged datagrams that would end a process or use up its memory, since RustDDS does not check
//! them.

#![allow(clippy::unwrap_used, clippy::panic, reason = "test code, also outside of test functions")]

#[path = "../../../tests/src/siege/forger.rs"]
mod forger;
mod world;

use std::collections::HashMap;
use std::net::UdpSocket;
use std::sync::Arc;
use std::time::Duration;

use forger::{
    Forger, USER, WRITERS, acknack, announcement_ports, data, fragment, gap, heartbeat,
    nack_fragments, ports, submessage,
};
use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::{Address, Policy, PortSpec, Ports, Publisher, Subscription};
use genom_ros2::{Options, Ros2, ServiceMapping};
use genom_types::Record;
use world::Domain;

const TOPIC: &str = "rt/demo/state";

/// Two daemons that communicate, and an attacker on their network.
struct World {
    domain: Domain,
    publisher: Box<dyn Publisher>,
    subscription: Box<dyn Subscription>,
    record: Record,
    written: u64,
    socket: UdpSocket,
    forger: Forger,
    _daemons: [Arc<Ros2>; 2],
}

impl World {
    fn new() -> Self {
        let domain = Domain::new(ServiceMapping::Enhanced);
        // Each may hold eight samples of this size in fragments, and one participant half of them.
        let sizes = Options { greatest_sample: 1 << 20, ..domain.options() };
        // Nodes without services, so that each announces one end.
        let options = Options { parameters: false, type_descriptions: false, ..sizes };
        let daemons = [(); 2].map(|()| Ros2::open(&options).unwrap());
        let (ty, at) = (state(), Address::new("demo", "state"));
        let publisher = daemons[0].publisher(&PortSpec::new(&at, &ty)).unwrap();
        let subscription =
            daemons[1].subscription(&PortSpec::new(&at, &ty), Policy::Latest).unwrap();
        let socket = UdpSocket::bind(("127.0.0.1", 0)).unwrap();
        socket.set_read_timeout(Some(Duration::from_millis(20))).unwrap();
        let mut world = Self {
            domain,
            publisher,
            subscription,
            record: numbered(0),
            written: 0,
            socket,
            forger: Forger(*b"\x01\x10forged....."[..12].first_chunk().unwrap()),
            _daemons: daemons,
        };
        world.flows("at first");
        world
    }

    fn number(&self) -> u16 {
        self.domain.number()
    }

    fn send(&self, message: &[u8]) {
        for port in ports(self.number()) {
            // There need not be a listener on each port.
            let _ = self.socket.send_to(message, ("127.0.0.1", port));
        }
    }

    /// Checks that what is written from now on is read.
    fn flows(&mut self, after: &str) {
        let before = self.written;
        eventually(&format!("a sample arrives, {after}"), || {
            self.written += 1;
            self.publisher.publish(&numbered(self.written)).unwrap();
            // The record is unchanged if nothing is read.
            let _ = self.subscription.read(&mut self.record);
            number(&self.record) > before
        });
    }

    /// Announces itself and a writer of the topic. Returns the participants it discovers, each with
    /// its writer of the topic if it has one.
    fn join(&mut self) -> HashMap<[u8; 12], Option<[u8; 4]>> {
        let port = self.socket.local_addr().unwrap().port();
        let (mut there, mut count) = (HashMap::new(), 0);
        eventually("the daemons tell who they are", || {
            count += 1;
            let announcement = self.forger.announcement(count, port, 100);
            for to in announcement_ports(self.number()) {
                let _ = self.socket.send_to(&announcement, ("127.0.0.1", to));
            }
            let mut buffer = [0; 65536];
            while let Ok((length, from)) = self.socket.recv_from(&mut buffer) {
                let heard = &buffer[..length];
                let Some(Ok(prefix)) = heard.get(8..20).map(<[u8; 12]>::try_from) else { continue };
                let known = there.entry(prefix).or_insert(None);
                if let Some(guid) = writer_of(heard) {
                    *known = Some(guid);
                } else if known.is_none() {
                    let ask = self.forger.message(&[acknack(&prefix, WRITERS, count as i32)]);
                    self.socket.send_to(&ask, from).unwrap();
                    self.send(&ask);
                }
            }
            there.len() >= 2 && there.values().any(Option::is_some)
        });
        self.send(&self.forger.writer(TOPIC, "demo::msg::dds_::Small_"));
        there
    }
}

/// The writer of the topic, if the datagram announces it.
fn writer_of(heard: &[u8]) -> Option<[u8; 4]> {
    let holds = |bytes: &[u8]| heard.windows(bytes.len()).position(|window| window == bytes);
    holds(TOPIC.as_bytes())?;
    holds(&WRITERS)?;
    let at = holds(&[0x5a, 0, 16, 0])? + 16;
    heard.get(at..at + 4)?.try_into().ok()
}

/// Peak memory of this process in bytes.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() << 10
}

fn attacks(writer: [u8; 4]) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for last in [1 << 31, 1 << 40, 1 << 62, i64::MAX] {
        all.push((format!("a heartbeat up to {last}"), heartbeat(writer, 1, last, 1 << 20)));
    }
    for (start, end) in [(1, 1 << 40), (2, 1 << 40), (5, i64::MAX), (i64::MIN, i64::MAX), (9, 1)] {
        all.push((format!("a gap from {start} to {end}"), gap(writer, start, end)));
    }
    for whole in [u32::MAX, u32::MAX - 9, 1 << 31] {
        for (size, number) in [(1, 1), (1000, 1), (u16::MAX, 1), (1000, 1 << 40)] {
            let piece = fragment(writer, number, (1, 1, size), whole, &[0; 1000]);
            all.push((format!("a fragment of {whole} bytes by {size}"), piece));
        }
    }
    all.push(("a sample far ahead".to_owned(), data(writer, 1 << 60, &[0, 1, 0, 0, 1, 0, 0, 0])));
    for base in [0, 1, u32::MAX - 255, u32::MAX] {
        all.push((format!("a request for fragment {base}"), nack_fragments(writer, 1, base, 7)));
    }
    all
}

#[test]
fn no_single_datagram_takes_memory_or_ends_a_flow() {
    let mut world = World::new();
    let there = world.join();
    let before = peak();
    let own = world.forger;
    for (what, attack) in attacks(USER).into_iter().chain(attacks(WRITERS)) {
        world.send(&own.message(&[attack]));
        world.flows(&what);
    }
    // In the name of a daemon: of its port's writer, and of its announcements.
    for (prefix, writer) in there {
        for (what, attack) in [writer, Some(WRITERS)].into_iter().flatten().flat_map(attacks) {
            world.send(&Forger(prefix).message(&[attack]));
            world.flows(&format!("{what}, in another's name"));
        }
    }
    // The kernel sums up counters of threads, and may lag behind by some pages.
    let grown = peak().saturating_sub(before) >> 20;
    assert!(grown < 64, "{grown} MiB more");
}

/// Pseudo-random numbers (xorshift), the same in each run.
struct Chance(u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: u64) -> u64 {
        self.next() % end
    }

    /// A small number, one near a power of two, or any.
    fn number(&mut self) -> i64 {
        match self.below(3) {
            0 => self.below(30).cast_signed() - 3,
            1 => (1_i64 << self.below(63)).wrapping_add(self.below(3).cast_signed() - 1),
            _ => self.next().cast_signed(),
        }
    }

    fn submessage(&mut self, writer: [u8; 4]) -> Vec<u8> {
        let mut made = match self.below(7) {
            0 => heartbeat(writer, self.number(), self.number(), self.number() as i32),
            1 => gap(writer, self.number(), self.number()),
            2 => {
                let part = (self.number() as u32, self.number() as u16, self.number() as u16);
                fragment(writer, self.number(), part, self.number() as u32, &[7; 300])
            }
            3 => data(writer, self.number(), &[0, 3, 0, 0, 0x5a, 0, 16, 0]),
            4 => nack_fragments(writer, self.number(), self.number() as u32, self.number() as i32),
            5 => acknack(&[0; 12], writer, self.number() as i32),
            _ => {
                let body: Vec<u8> = (0..self.below(80)).map(|_| self.next() as u8).collect();
                submessage(self.next() as u8, self.next() as u8, &body)
            }
        };
        // Often one byte is changed, too.
        if self.below(2) == 0 {
            let at = self.below(made.len() as u64) as usize;
            made[at] = self.next() as u8;
        }
        made
    }
}

#[test]
fn a_storm_of_nonsense_takes_little_memory_and_leaves_the_flow() {
    let mut world = World::new();
    let there = world.join();
    let writers: Vec<_> =
        [USER, WRITERS].into_iter().chain(there.values().flatten().copied()).collect();
    let before = peak();
    let mut chance = Chance(0x5eed);
    for round in 0..40 {
        for _ in 0..250 {
            let writer = writers[chance.below(writers.len() as u64) as usize];
            let parts: Vec<_> = (0..=chance.below(4)).map(|_| chance.submessage(writer)).collect();
            world.send(&world.forger.message(&parts));
        }
        world.flows(&format!("after {} datagrams", (round + 1) * 250));
    }
    // Linux counts pages in batches, so that a later peak can read lower.
    let grown = peak().saturating_sub(before) >> 20;
    assert!(grown < 64, "{grown} MiB more");
}
