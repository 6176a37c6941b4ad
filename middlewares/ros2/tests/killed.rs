//! A daemon that is killed leaves its addresses at once, though DDS misses it much later.

mod world;

use std::process::{Command, Stdio};

use genom_middleware::conformance::eventually;
use genom_middleware::conformance::samples::{number, numbered, state};
use genom_middleware::{Address, Endpoint, EndpointKind, Middleware, OpenError, Policy, Reading};
use genom_ros2::ServiceMapping;
use genom_types::Record;
use world::Domain;

#[test]
fn the_address_of_a_killed_daemon_is_free_and_its_reader_goes_on() {
    let domain = Domain::new(ServiceMapping::Enhanced);
    let ros2 = domain.open();
    let at = Address::new("demo", "position");
    let mut reader = ros2.subscription(&at, &state(), Policy::Latest).unwrap();
    let mut writer = Command::new(env!("CARGO_BIN_EXE_ros2-writer"))
        .arg(domain.options().domain.to_string())
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let mut got = Record::new(&state());
    eventually("its sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(number(&got), 9);
    assert!(matches!(ros2.publisher(&at, &state()), Err(OpenError::Taken { .. })));
    writer.kill().unwrap();
    writer.wait().unwrap();
    let mut next = ros2.publisher(&at, &state()).expect("the address is free");
    let seen = ros2.discover().unwrap();
    let here =
        |end: &&Endpoint| end.kind == EndpointKind::Publisher && end.address == at.to_string();
    let writers = seen.iter().filter(here).count();
    assert_eq!(writers, 1, "the killed one is not listed: {seen:?}");
    next.publish(&numbered(10)).unwrap();
    eventually("the next writer is read", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(number(&got), 10);
}
