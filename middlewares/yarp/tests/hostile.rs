//! Who dials our ports with anything but YARP harms nobody: limits, memory, and those who go on.

#![allow(clippy::unwrap_used, reason = "test code outside of test functions")]

mod world;

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use genom_conformance::samples::{number, numbered, state};
use genom_conformance::{World as _, eventually};
use genom_middleware::{
    Address, Middleware, Outcome, Policy, PortSpec, Ports, Publisher, Reading, Replies,
    ServiceHandler, ServiceKind, ServiceType, Services, Subscription,
};
use genom_types::Record;
use genom_yarp::{Options, Yarp};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use world::{Place, has, until};

fn position() -> Address {
    Address::new("demo", "position")
}

/// Both ends of a port, in two processes as far as YARP is concerned, and where they listen.
struct Pair {
    place: Place,
    reads: Arc<Yarp>,
    writer: Box<dyn Publisher>,
    reader: Box<dyn Subscription>,
    _writes: Arc<Yarp>,
    n: u64,
}

impl Pair {
    fn new() -> Self {
        let place = Place::new();
        let (writes, reads) = (place.open(), place.open());
        let ty = state();
        let writer = writes.publisher(&PortSpec::new(&position(), &ty)).unwrap();
        let reader = reads.subscription(&PortSpec::new(&position(), &ty), Policy::Latest).unwrap();
        let mut pair = Self { place, reads, writer, reader, _writes: writes, n: 0 };
        pair.works();
        pair
    }

    /// Where the in port listens.
    fn at(&self) -> (String, u16) {
        let names = self.place.leftovers();
        let name = names.iter().find(|name| name.contains(":i/")).unwrap();
        self.place.address_of(name)
    }

    fn dial(&self) -> TcpStream {
        let stream = TcpStream::connect(self.at()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        stream
    }

    /// A sample goes from the one to the other.
    fn works(&mut self) {
        self.n += 1;
        self.writer.publish(&numbered(self.n)).unwrap();
        let mut got = Record::new(&state());
        eventually("the sample arrives", || {
            self.reader.read(&mut got).unwrap() == Reading::New && number(&got) == self.n
        });
    }

    fn refused(&self, why: &str) -> u64 {
        let all = self.reads.refused();
        all.iter().find(|one| one.why == why).map_or(0, |one| one.count)
    }
}

const NO_YARP: &str = "what does not speak YARP";

/// As one who dials with fast_tcp begins.
fn hello() -> Vec<u8> {
    [&b"YA\x64\x1e\0\0RP"[..], &4u32.to_le_bytes(), b"/me\0"].concat()
}

/// The header of a message with blocks of these sizes.
fn index(sizes: &[u32]) -> Vec<u8> {
    let mut bytes = b"YA\x0a\0\0\0RP".to_vec();
    bytes.extend_from_slice(&[sizes.len() as u8, 0]);
    bytes.extend_from_slice(&[0xff; 8]);
    bytes.extend(sizes.iter().flat_map(|size| size.to_le_bytes()));
    bytes
}

/// A message with a bottle.
fn message(bottle: &[u8]) -> Vec<u8> {
    let size = bottle.len() as u32;
    [&index(&[8, size])[..], b"\0\0\0\0~D\0\x01", bottle].concat()
}

/// Whether the peer has ended the connection.
fn ends(stream: &mut TcpStream) -> bool {
    let mut rest = Vec::new();
    // A reset is an end, too.
    stream.read_to_end(&mut rest).map_or(true, |_| true)
}

#[test]
fn what_is_no_yarp_is_refused_and_those_who_speak_it_go_on() {
    let mut pair = Pair::new();
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

#[test]
fn bottles_that_lie_about_their_size_are_counted_and_take_no_memory() {
    let mut pair = Pair::new();
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

#[test]
fn half_a_message_and_silence_is_ended_and_counted() {
    let mut pair = Pair::new();
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

#[test]
fn thousands_of_connections_take_nothing_from_the_one_that_sends() {
    let mut pair = Pair::new();
    // Both ends of each connection are in this process.
    let most = getrlimit(Resource::Nofile).maximum;
    setrlimit(Resource::Nofile, Rlimit { current: most, maximum: most }).unwrap();
    let (mut crowd, at) = (Vec::new(), pair.at());
    for n in 0..3000 {
        let mut stream = TcpStream::connect(&at).unwrap();
        if n % 3 == 0 {
            let _ = stream.write_all(b"CONNACK crowd\r\n");
        }
        crowd.push(stream);
        if n % 500 == 0 {
            pair.works();
        }
    }
    // Some made room for others, and the time of some was up.
    let went =
        || pair.refused("too many connections") + pair.refused("a connection without an end");
    eventually("no more are open than may be", || went() >= 3000 - 1024);
    pair.works();
    // One more who speaks YARP is served.
    let mut stream = pair.dial();
    stream.write_all(b"CONNACK tool\r\n*\r\n").unwrap();
    let mut said = [0; 15];
    stream.read_exact(&mut said).unwrap();
    assert_eq!(&said, b"Welcome tool\r\nT");
}

struct Echo;

impl ServiceHandler for Echo {
    fn request(&self, input: Record, replies: Box<dyn Replies>) {
        replies.finish(Outcome::Success(input));
    }

    fn cancel(&self, _: genom_middleware::ActivityId) {}
}

#[test]
fn requests_that_are_no_requests_are_answered_or_ended() {
    let place = Place::new();
    let yarp = place.open();
    let echo = ServiceType::new(ServiceKind::Function, state(), state());
    let at = Address::new("demo", "echo");
    let _served = yarp.serve(&at, &echo, Arc::new(Echo)).unwrap();
    let dial = || {
        let stream = TcpStream::connect(place.address_of("/demo/rpc")).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        stream
    };
    for text in ["(((((", "echo 1 (2", "\"", "[toolong]", "{300}", &"(".repeat(100_000)] {
        let mut stream = dial();
        stream.write_all(format!("CONNACK x\r\nd\r\n{text}\r\n").as_bytes()).unwrap();
        let said = until(&mut stream, b"<ACK>").unwrap();
        assert!(has(&said, b"<ACK>"), "{text:.20}");
    }
    // Requests whose answers nobody reads.
    let mut deaf = dial();
    deaf.write_all(b"CONNECT x\r\n").unwrap();
    let request = b"d\r\nhelp\r\n".repeat(20_000);
    deaf.set_write_timeout(Some(Duration::from_millis(500))).unwrap();
    let _ = deaf.write_all(&request);
    let (other, echo) = (place.open(), echo);
    let mut client = other.client(&at, &echo).unwrap();
    let answer = client.call(&numbered(3), Duration::from_secs(30)).unwrap();
    assert!(matches!(answer, Outcome::Success(output) if number(&output) == 3));
}

#[test]
fn a_name_server_that_is_none_is_told_apart_from_one_that_is_absent_or_silent() {
    let open = |port: u16| {
        let options = Options { server: format!("127.0.0.1:{port}"), ..Options::default() };
        let yarp = Yarp::open(&options).unwrap();
        let opened = yarp.publisher(&PortSpec::new(&position(), &state()));
        opened.err().unwrap().to_string()
    };
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let answering = |answer: &'static [u8]| {
        let listener = listener.try_clone().unwrap();
        thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            let _ = stream.write_all(answer);
            // Until the other side gives up.
            let _ = stream.read_to_end(&mut Vec::new());
        })
    };
    let web = answering(b"HTTP/1.1 400 Bad Request\r\n\r\n");
    let error = open(port);
    assert!(error.contains("is no YARP name server: it says \"HTTP/1.1 400"), "{error}");
    web.join().unwrap();
    let silent = answering(b"");
    let error = open(port);
    assert!(error.contains("does not answer within 3s"), "{error}");
    silent.join().unwrap();
    drop(listener);
    let error = open(port);
    assert!(error.contains("no YARP name server is at") && error.contains("refused"), "{error}");
}
