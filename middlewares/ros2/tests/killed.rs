//! The addresses of a killed daemon are free at once, although DDS notices its end much later.

mod world;

use std::io::Read as _;
use std::process::Stdio;

use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, state};
use genom_middleware::{
    Address, Discovery, Endpoint, EndpointKind, OpenError, Policy, PortSpec, Ports, Reading,
};
use genom_ros2::{Options, Ros2, ServiceMapping};
use genom_types::Record;
use world::Domain;

/// Environment variable with the domain of the process that is killed.
const DOMAIN: &str = "GENOM_ROS2_WRITER_DOMAIN";

#[test]
#[ignore = "is another process, which the next test starts"]
fn writes_until_it_is_killed() {
    let Ok(domain) = std::env::var(DOMAIN) else { return };
    let options = Options { domain: domain.parse().ok(), ..Options::default() };
    let ros2 = Ros2::open(&options).unwrap();
    let at = Address::new("demo", "position");
    let mut writer = ros2.publisher(&PortSpec::new(&at, &state())).unwrap();
    writer.publish(&numbered(9)).unwrap();
    // Ends with the test if it is not killed before.
    let _ = std::io::stdin().read_to_end(&mut Vec::new());
}

#[test]
fn the_address_of_a_killed_daemon_is_free_and_its_reader_goes_on() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let at = Address::new("demo", "position");
    let mut reader = ros2.subscription(&PortSpec::new(&at, &state()), Policy::Latest).unwrap();
    let mut writer = genom_conformance::again("writes_until_it_is_killed")
        .env(DOMAIN, domain.number().to_string())
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let mut got = Record::new(&state());
    eventually("its sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(number(&got), 9);
    assert!(matches!(ros2.publisher(&PortSpec::new(&at, &state())), Err(OpenError::Taken { .. })));
    writer.kill().unwrap();
    writer.wait().unwrap();
    let mut next = ros2.publisher(&PortSpec::new(&at, &state())).expect("the address is free");
    let seen = ros2.discover().unwrap();
    let here =
        |end: &&Endpoint| end.kind == EndpointKind::Publisher && end.address == at.to_string();
    let writers = seen.iter().filter(here).count();
    assert_eq!(writers, 1, "the killed one is not listed: {seen:?}");
    next.publish(&numbered(10)).unwrap();
    eventually("the next writer is read", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(number(&got), 10);
}
