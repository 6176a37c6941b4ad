//! Who dials our ports with anything but YARP harms nobody: limits, memory, and those who go on.

#![allow(clippy::unwrap_used, reason = "test code outside of test functions")]

mod attack;
mod world;

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use attack::{Pair, position};
use genom_conformance::samples::{number, numbered, state};
use genom_conformance::{World, eventually};
use genom_middleware::{
    Address, Outcome, PortSpec, Ports, Replies, ServiceHandler, ServiceKind, ServiceType, Services,
};
use genom_types::Record;
use genom_yarp::{Options, Yarp};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
use world::{Place, has, until};

fn pair() -> Pair {
    Pair::new(World::join)
}

#[test]
fn what_is_no_yarp_is_refused_and_those_who_speak_it_go_on() {
    attack::without_yarp(&mut pair());
}

#[test]
fn bottles_that_lie_about_their_size_are_counted_and_take_no_memory() {
    attack::with_false_sizes(&mut pair());
}

#[test]
fn half_a_message_and_silence_is_ended_and_counted() {
    attack::by_silence(&mut pair());
}

#[test]
fn thousands_of_connections_take_nothing_from_the_one_that_sends() {
    let mut pair = pair();
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
