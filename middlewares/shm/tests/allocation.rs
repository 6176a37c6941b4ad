//! The real-time paths allocate nothing of our own.

mod world;

use genom_allocations as allocations;
use genom_conformance::samples::{number, numbered, set_number, state};
use genom_middleware::{Address, Policy, PortSpec, Ports, Reading};
use genom_types::Record;

use world::ShmWorld;

#[test]
fn reading_allocates_nothing_and_writing_only_what_iceoryx2_does_per_loan() {
    const ROUNDS: u64 = 10_000;
    let world = ShmWorld::new();
    let shm = world.open();
    let at = Address::new("demo", "position");
    let mut writer = shm.publisher(&PortSpec::new(&at, &state())).unwrap();
    let policies = [Policy::Latest, Policy::Ring(4)];
    let mut readers =
        policies.map(|policy| shm.subscription(&PortSpec::new(&at, &state()), policy).unwrap());
    let (mut sent, mut got) = (numbered(0), Record::new(&state()));
    let (mut writing, mut reading) = (0, 0);
    for n in 0..=ROUNDS {
        set_number(&mut sent, n);
        let before = allocations::count();
        writer.publish(&sent).unwrap();
        let between = allocations::count();
        for reader in &mut readers {
            assert_eq!(reader.read(&mut got), Ok(Reading::New));
            assert_eq!(number(&got), n);
            assert_eq!(reader.read(&mut got), Ok(Reading::Same));
        }
        // The first round connects.
        if n > 0 {
            writing += between - before;
            reading += allocations::count() - between;
        }
    }
    // iceoryx2 allocates a reference-counted handle per loaned sample and frees it when the sample
    // is sent.
    assert_eq!((writing, reading), (2 * ROUNDS, 0));
}
