//! Attacks on a port that are the same whoever has it: this process as it is, or a library that is
//! opened as a plugin. Both ends of the port work after each.

#![allow(dead_code, clippy::unwrap_used, reason = "shared by test programs, which use parts of it")]

use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;

use genom_conformance::samples::{number, numbered, state};
use genom_conformance::{World as _, eventually};
use genom_middleware::{Address, Middleware, Policy, PortSpec, Publisher, Reading, Subscription};
use genom_types::Record;

use crate::world::Place;

pub(crate) fn position() -> Address {
    Address::new("demo", "position")
}

/// Both ends of a port, in two processes as far as YARP is concerned, and where they listen.
pub(crate) struct Pair {
    place: Place,
    pub(crate) reads: Arc<dyn Middleware>,
    writer: Box<dyn Publisher>,
    reader: Box<dyn Subscription>,
    _writes: Arc<dyn Middleware>,
    n: u64,
}

impl Pair {
    /// With participants that `open` makes.
    pub(crate) fn new(open: impl Fn(&Place) -> Arc<dyn Middleware>) -> Self {
        let place = Place::new();
        let (writes, reads) = (open(&place), open(&place));
        let ty = state();
        let writer = writes.publisher(&PortSpec::new(&position(), &ty)).unwrap();
        let reader = reads.subscription(&PortSpec::new(&position(), &ty), Policy::Latest).unwrap();
        let mut pair = Self { place, reads, writer, reader, _writes: writes, n: 0 };
        pair.works();
        pair
    }

    /// Where the in port listens.
    pub(crate) fn at(&self) -> (String, u16) {
        let names = self.place.leftovers();
        let name = names.iter().find(|name| name.contains(":i/")).unwrap();
        self.place.address_of(name)
    }

    pub(crate) fn dial(&self) -> TcpStream {
        let stream = TcpStream::connect(self.at()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        stream
    }

    /// A sample goes from the one to the other.
    pub(crate) fn works(&mut self) {
        self.n += 1;
        self.writer.publish(&numbered(self.n)).unwrap();
        let mut got = Record::new(&state());
        eventually("the sample arrives", || {
            self.reader.read(&mut got).unwrap() == Reading::New && number(&got) == self.n
        });
    }

    pub(crate) fn refused(&self, why: &str) -> u64 {
        let all = self.reads.refused();
        all.iter().find(|one| one.why == why).map_or(0, |one| one.count)
    }
}

pub(crate) const NO_YARP: &str = "what does not speak YARP";

/// As one who dials with fast_tcp begins.
pub(crate) fn hello() -> Vec<u8> {
    [&b"YA\x64\x1e\0\0RP"[..], &4u32.to_le_bytes(), b"/me\0"].concat()
}

/// The header of a message with blocks of these sizes.
pub(crate) fn index(sizes: &[u32]) -> Vec<u8> {
    let mut bytes = b"YA\x0a\0\0\0RP".to_vec();
    bytes.extend_from_slice(&[sizes.len() as u8, 0]);
    bytes.extend_from_slice(&[0xff; 8]);
    bytes.extend(sizes.iter().flat_map(|size| size.to_le_bytes()));
    bytes
}

/// A message with a bottle.
pub(crate) fn message(bottle: &[u8]) -> Vec<u8> {
    let size = bottle.len() as u32;
    [&index(&[8, size])[..], b"\0\0\0\0~D\0\x01", bottle].concat()
}

/// Whether the peer has ended the connection.
pub(crate) fn ends(stream: &mut TcpStream) -> bool {
    let mut rest = Vec::new();
    // A reset is an end, too.
    stream.read_to_end(&mut rest).map_or(true, |_| true)
}

/// What is no YARP is refused and counted.
pub(crate) fn without_yarp(pair: &mut Pair) {
    let after = |bytes: &[u8]| [&hello()[..], bytes].concat();
    let attacks = [
        b"GET / HTTP/1.1\r\nHost: robot\r\n\r\n".to_vec(),
        b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03".to_vec(),
        // Names of 2^31 - 1, of a negative number and of no bytes, and one that is no text.
        [&b"YA\x64\x1e\0\0RP"[..], &i32::MAX.to_le_bytes()].concat(),
        [&b"YA\x64\x1e\0\0RP"[..], &(-1i32).to_le_bytes()].concat(),
        [&b"YA\x64\x1e\0\0RP"[..], &0i32.to_le_bytes()].concat(),
        [&b"YA\x64\x1e\0\0RP"[..], &2u32.to_le_bytes(), b"\xff\0"].concat(),
        // udp, for which nothing is opened here.
        b"YA\x61\x1e\0\0RP\x04\0\0\0/me\0".to_vec(),
        after(b"12345678"),
        after(&index(&[1 << 31])),
        after(&index(&[u32::MAX; 255])),
        after(&index(&[])),
        after(&[&index(&[4])[..], b"body"].concat()),
        after(&[&index(&[9])[..], b"\xff\xff\xff\x7f~\0\0\x01D"].concat()),
        [&b"CONNECT me\n"[..], &vec![b'x'; 1 << 20]].concat(),
    ];
    for (count, attack) in (1..).zip(&attacks) {
        let mut stream = pair.dial();
        // It may be closed before all is written.
        let _ = stream.write_all(attack);
        assert!(ends(&mut stream), "{}", attack.escape_ascii().take(40).collect::<Vec<_>>().len());
        eventually("it is counted", || pair.refused(NO_YARP) == count);
        pair.works();
    }
}

/// Bottles that lie about their size are counted, and take no memory.
pub(crate) fn with_false_sizes(pair: &mut Pair) {
    let word = |word: u32| word.to_le_bytes().to_vec();
    let list = |code: u32, count: u32| [word(code), word(count)].concat();
    let deep: Vec<u8> = (0..500).flat_map(|_| list(256, 1)).collect();
    let bottles = [
        Vec::new(),
        word(256),
        list(256, u32::MAX),
        list(256, i32::MAX as u32),
        list(256 + 10, i32::MAX as u32),
        list(256 + 4, 2),
        [list(256, 2), word(0x11), vec![0; 8], list(256 + 10, 1 << 30)].concat(),
        [list(256, 2), word(12), word(i32::MAX as u32)].concat(),
        [list(256, 1), word(3)].concat(),
        list(7, 1),
        deep,
    ];
    let mut stream = pair.dial();
    stream.write_all(&hello()).unwrap();
    for (count, bottle) in (1..).zip(&bottles) {
        stream.write_all(&message(bottle)).unwrap();
        eventually("it is counted", || pair.reader.dropped() == count);
    }
    pair.works();
    let why = "a bottle that is no sample of its port's type";
    assert_eq!(pair.refused(why), bottles.len() as u64);
}

/// Half a message and silence is ended and counted.
pub(crate) fn by_silence(pair: &mut Pair) {
    let mut silent: Vec<TcpStream> = Vec::new();
    for beginning in [&b""[..], b"YA", &hello()[..10], b"CONNECT x"] {
        let mut stream = pair.dial();
        stream.write_all(beginning).unwrap();
        silent.push(stream);
    }
    for stream in &mut silent {
        assert!(ends(stream));
    }
    let why = "a connection without an end";
    eventually("they are counted", || pair.refused(why) == silent.len() as u64);
    pair.works();
}
