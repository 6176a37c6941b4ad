//! The real-time paths of this backend allocate nothing.

use genom_allocations as allocations;
use genom_conformance::samples::{number, numbered, set_number, state};
use genom_local::Local;
use genom_middleware::{Address, Policy, PortSpec, Ports, Reading};
use genom_types::Record;

#[test]
fn writing_and_reading_fixed_types_allocates_nothing() {
    let local = Local::new();
    let at = Address::new("demo", "position");
    let mut writer = local.publisher(&PortSpec::new(&at, &state())).unwrap();
    let policies = [Policy::Latest, Policy::Queue(4), Policy::Ring(4)];
    let mut readers =
        policies.map(|policy| local.subscription(&PortSpec::new(&at, &state()), policy).unwrap());
    let (mut sent, mut got) = (numbered(0), Record::new(&state()));
    let mut round = |n| {
        set_number(&mut sent, n);
        writer.publish(&sent).unwrap();
        for reader in &mut readers {
            assert_eq!(reader.read(&mut got), Ok(Reading::New));
            assert_eq!(number(&got), n);
            assert_eq!(reader.read(&mut got), Ok(Reading::Same));
        }
    };
    round(1);
    assert_eq!(allocations::within(|| (2..10_000).for_each(&mut round)), 0);
}
