//! What is written after a connection ended does not arrive.

#![allow(clippy::unwrap_used, reason = "test code outside of test functions")]

mod world;

use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

use genom_conformance::samples::{numbered, state};
use genom_middleware::{Address, PortSpec, Ports as _};
use world::{Place, has, until};

const PATIENCE: Option<Duration> = Some(Duration::from_secs(30));

/// The last number of a sample, which those before have not.
fn mark(n: u64) -> [u8; 8] {
    ((n + 6) as f64).to_le_bytes()
}

#[test]
fn a_sample_that_is_written_after_the_answer_to_a_disconnection_does_not_arrive() {
    let place = Place::new();
    let yarp = place.open();
    let at = Address::new("demo", "position");
    let mut writer = yarp.publisher(&PortSpec::new(&at, &state())).unwrap();
    // A reader as it is seen from the network.
    let reader = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = reader.local_addr().unwrap().port();
    place.ask(&format!("register /r tcp 127.0.0.1 {port}")).unwrap();
    let mut asking = TcpStream::connect(place.address_of("/demo/position")).unwrap();
    asking.set_read_timeout(PATIENCE).unwrap();
    asking.set_nodelay(true).unwrap();
    asking.write_all(b"CONNECT /me\r\n").unwrap();
    until(&mut asking, b"Welcome").unwrap();
    writer.publish(&numbered(1)).unwrap();
    for n in 2..300 {
        asking.write_all(b"fast_tcp://r\r\n").unwrap();
        let (mut stream, _) = reader.accept().unwrap();
        stream.set_read_timeout(PATIENCE).unwrap();
        // The greeting is a number, a length and a name; what answers it is a number, too.
        stream.read_exact(&mut [0; 8 + 4 + b"/demo/position\0".len()]).unwrap();
        stream.write_all(b"YA\0\0\0\0RP").unwrap();
        until(&mut asking, b"Added connection").unwrap();
        until(&mut stream, &mark(n - 1)).unwrap();
        asking.write_all(b"!/r\r\n").unwrap();
        until(&mut asking, b"Removed connection").unwrap();
        writer.publish(&numbered(n)).unwrap();
        let mut rest = Vec::new();
        stream.read_to_end(&mut rest).unwrap();
        assert!(!has(&rest, &mark(n)), "sample {n} arrived after the disconnection");
    }
}
