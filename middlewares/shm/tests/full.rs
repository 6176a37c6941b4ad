//! Full shared memory is reported as an error and does not end the process.

mod world;

use genom_conformance::samples::state;
use genom_middleware::{Address, OpenError, PortSpec, Ports};
use genom_shm::{Options, Shm};

use world::ShmWorld;

#[test]
fn no_port_is_opened_where_nothing_is_left() {
    let world = ShmWorld::new();
    let full = Shm::open(Options { keep_free: u64::MAX, ..world.options() }).unwrap();
    let at = Address::new("demo", "position");
    let Err(OpenError::Failed { why, .. }) =
        full.publisher(&PortSpec::new(&at, &state())).map(drop)
    else {
        panic!("it was opened");
    };
    assert!(why.contains("of shared memory are left: enlarge /dev/shm"), "{why}");
    // With the memory that is really left, it works.
    world.open().publisher(&PortSpec::new(&at, &state())).unwrap();
}
