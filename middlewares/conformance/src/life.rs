//! Opening, closing and reopening of ports and backends; nothing stays behind.

use genom_types::Record;

use crate::harness::{World, eventually};
use crate::ports::{position, read, read_until, reader, writer};
use crate::samples::{note, numbered, other_state, state};
use genom_middleware::{Address, EndpointKind, OpenError, Policy, PortSpec, Reading};

/// Capabilities are what the backend really does; the rest is refused with a reason.
pub fn what_a_backend_says_it_can_do_it_does(world: &dyn World) {
    let one = world.join();
    assert_eq!(one.services().is_some(), one.capabilities().services, "its services");
    assert!(one.capabilities().services || !one.capabilities().native_services);
    assert!(!one.name().is_empty() && one.name() == world.join().name());
    if one.discovery().is_none() {
        let refused = one.discover().expect_err("a list of what cannot be known");
        assert!(refused.backend == one.name() && !refused.why.is_empty(), "{refused}");
    }
}

/// An address has one writer.
pub fn a_second_writer_of_an_address_is_refused(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let first = writer(&a);
    for side in [&a, &b] {
        eventually("the second writer is refused", || {
            match side.publisher(&PortSpec::new(&position(), &state())) {
                Err(OpenError::Taken { address }) => address == position(),
                Err(other) => panic!("refused for another reason: {other}"),
                // Middlewares that discover in the background may not have seen the first yet.
                Ok(second) => {
                    drop(second);
                    false
                }
            }
        });
    }
    drop(first);
    eventually("the address is free again", || {
        b.publisher(&PortSpec::new(&position(), &state())).is_ok()
    });
}

/// A reader stays connected to the address, whichever writer has it.
pub fn a_writer_may_go_and_come_back(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let mut reader = reader(&b, Policy::Latest);
    for round in 1..10 {
        let mut writer = writer(&a);
        writer.publish(&numbered(round)).unwrap();
        read_until(&mut *reader, round);
        drop(writer);
        assert_eq!(read(&mut *reader).0, Reading::Same);
    }
}

/// A value lives as long as its writer.
pub fn a_late_reader_sees_nothing_of_a_writer_that_left(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let mut first = writer(&a);
    first.publish(&numbered(5)).unwrap();
    let gone = || b.ends_at(&position()).expect("a list").is_empty();
    let tells = b.discovery().is_some();
    if tells {
        // Else it would seem to have gone before it was seen.
        eventually("the writer is there", || !gone());
    }
    drop(first);
    // Some backends send what is left, and withdraw the port then, after it was dropped: a reader
    // that comes in between may still get the value.
    if tells {
        eventually("the writer has gone", gone);
    }
    let mut late = reader(&b, Policy::Latest);
    assert_eq!(read(&mut *late).0, Reading::Never);
    let mut second = writer(&a);
    assert_eq!(read(&mut *late).0, Reading::Never);
    second.publish(&numbered(6)).unwrap();
    read_until(&mut *late, 6);
}

/// After a port is closed, its address can be opened with another type.
pub fn a_closed_address_takes_another_type(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let (mut old_writer, mut old_reader) = (writer(&a), reader(&b, Policy::Latest));
    old_writer.publish(&numbered(3)).unwrap();
    read_until(&mut *old_reader, 3);
    drop((old_writer, old_reader));
    let other = other_state();
    eventually("the address takes another type", || {
        a.publisher(&PortSpec::new(&position(), &other)).is_ok()
    });
    let mut writer = a.publisher(&PortSpec::new(&position(), &other)).unwrap();
    let mut reader = b.subscription(&PortSpec::new(&position(), &other), Policy::Latest).unwrap();
    let mut sent = Record::new(&other);
    sent.set_bytes(&[0x3f; 64]).unwrap();
    writer.publish(&sent).unwrap();
    let mut got = Record::new(&other);
    eventually("the sample arrives", || reader.read(&mut got).unwrap() == Reading::New);
    assert_eq!(got.bytes(), sent.bytes());
}

/// All participants see open ports and their types, and none sees closed ones.
pub fn discovery_shows_what_is_open_only(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    if a.discovery().is_none() {
        return;
    }
    let at = Address::new("robot", "arm/left");
    let shows = |kind: EndpointKind, address: &Address| {
        let seen = b.discover().expect("a list");
        seen.into_iter().find(|end| end.kind == kind && end.address == address.to_string())
    };
    let writer = a.publisher(&PortSpec::new(&at, &state())).unwrap();
    let reader = a.subscription(&PortSpec::new(&position(), &state()), Policy::Latest).unwrap();
    eventually("the out port shows", || shows(EndpointKind::Publisher, &at).is_some());
    let ty = shows(EndpointKind::Publisher, &at).map(|end| end.ty);
    assert!(ty.as_ref().is_some_and(|ty| ty.contains("state")), "its type is named: {ty:?}");
    eventually("the in port shows", || shows(EndpointKind::Subscription, &position()).is_some());
    assert_eq!(shows(EndpointKind::Publisher, &position()), None);
    // Listing a single address gives the same result.
    let kinds = |address: &Address| -> Vec<EndpointKind> {
        b.ends_at(address).expect("a list").iter().map(|end| end.kind).collect()
    };
    assert_eq!(kinds(&at), [EndpointKind::Publisher]);
    assert_eq!(kinds(&position()), [EndpointKind::Subscription]);
    drop((writer, reader));
    eventually("all is gone", || {
        shows(EndpointKind::Publisher, &at).is_none()
            && shows(EndpointKind::Subscription, &position()).is_none()
    });
    assert_eq!(kinds(&at), []);
}

/// A daemon ends and starts again while another one stays.
pub fn a_backend_may_be_closed_and_opened_again(world: &dyn World) {
    let stays = world.join();
    let mut reader = reader(&stays, Policy::Latest);
    for round in 1..4 {
        let comes = world.join();
        let mut writer = writer(&comes);
        writer.publish(&numbered(round)).unwrap();
        read_until(&mut *reader, round);
    }
}

/// Neither files nor shared memory nor names stay behind.
pub fn closing_leaves_nothing_behind(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let (mut writer, mut reader) = (writer(&a), reader(&b, Policy::Queue(3)));
    writer.publish(&numbered(4)).unwrap();
    read_until(&mut *reader, 4);
    let variable = a
        .capabilities()
        .variable_size
        .then(|| a.publisher(&PortSpec::new(&Address::new("demo", "note"), &note())).unwrap());
    drop((writer, variable, reader));
    drop((a, b));
    assert_eq!(world.leftovers(), Vec::<String>::new());
}

/// A port keeps alive what it needs of the backend.
pub fn ports_outlive_the_handle_they_were_opened_from(world: &dyn World) {
    let (a, b) = (world.join(), world.join());
    let (mut writer, mut reader) = (writer(&a), reader(&b, Policy::Latest));
    drop((a, b));
    writer.publish(&numbered(8)).unwrap();
    read_until(&mut *reader, 8);
}
