//! When a limit is reached, opening is refused and nothing else breaks. The only test of its
//! process, because it lowers limits of that process.

mod world;

use genom_conformance::World as _;
use genom_conformance::samples::{numbered, state};
use genom_middleware::{Address, OpenError, Policy, PortSpec, Ports};
use genom_shm::{Options, Shm};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use world::ShmWorld;

#[test]
fn limits_of_a_port_are_named_with_the_way_out_and_those_of_the_process_break_nothing() {
    let world = ShmWorld::new();
    let at = Address::new("demo", "position");
    let read = |shm: &Shm, policy| shm.subscription(&PortSpec::new(&at, &state()), policy);

    // The limits of a port, as configured.
    let small = Shm::open(Options { readers: 2, depth: 4, ..world.options() }).unwrap();
    let mut writer = small.publisher(&PortSpec::new(&at, &state())).unwrap();
    let refused = read(&small, Policy::Queue(5)).err().unwrap().to_string();
    let told = "at most 4 unread samples a reader (of large types, for 16 MiB of them), not 5: \
                ask for 4, or set backends.shm.depth";
    assert!(refused.contains(told), "{refused}");
    let readers: Vec<_> = (0..2).map(|_| read(&small, Policy::Ring(4)).unwrap()).collect();
    let refused = read(&small, Policy::Latest).err().unwrap().to_string();
    assert!(refused.contains("at most 2 readers") && refused.contains("backends.shm.readers"));
    writer.publish(&numbered(1)).unwrap();
    drop((readers, writer, small));

    // The limit of the process.
    let shm = world.open();
    let held = std::fs::read_dir("/proc/self/fd").unwrap().count() as u64;
    let before = getrlimit(Resource::Nofile);
    setrlimit(Resource::Nofile, Rlimit { current: Some(held + 30), ..before }).unwrap();
    let mut ports = Vec::new();
    let refused = loop {
        match shm.publisher(&PortSpec::new(
            &Address::new("demo", format!("port{}", ports.len())),
            &state(),
        )) {
            Ok(port) => ports.push(port),
            Err(error) => break error,
        }
        assert!(ports.len() < 100, "a port holds files");
    };
    setrlimit(Resource::Nofile, before).unwrap();
    // The caller reports this limit, because other middlewares reach it, too.
    assert!(matches!(refused, OpenError::Failed { .. }), "{refused}");
    assert!(ports.len() >= 8, "a port that nobody reads holds few files: {}", ports.len());
    // With more file descriptors, the refused port opens.
    let again = Address::new("demo", format!("port{}", ports.len()));
    shm.publisher(&PortSpec::new(&again, &state())).unwrap();
    drop((ports, shm));
    assert_eq!(world.leftovers(), Vec::<String>::new());
}
