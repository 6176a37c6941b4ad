//! The real-time paths of the example allocate nothing, as every backend must.

use genom_allocations as allocations;
use genom_conformance::eventually;
use genom_conformance::samples::{number, numbered, set_number, state};
use genom_example::{Example, Options};
use genom_middleware::{Address, Backend as _, Policy, PortSpec, Reading};
use genom_types::Record;

#[test]
fn writing_and_reading_fixed_types_allocates_nothing() {
    let example = Example::open(Options { board: "allocation".to_owned() }).unwrap();
    let (at, ty) = (Address::new("demo", "position"), state());
    let port = PortSpec::new(&at, &ty);
    let mut writer = example.publisher(&port).unwrap();
    let mut reader = example.subscription(&port, Policy::Latest).unwrap();
    let (mut sent, mut got) = (numbered(0), Record::new(&ty));
    let mut counted = 0;
    for n in 1..200 {
        set_number(&mut sent, n);
        counted += allocations::within(|| writer.publish(&sent).unwrap());
        eventually("the sample arrives", || {
            let mut reading = Reading::Same;
            counted += allocations::within(|| reading = reader.read(&mut got).unwrap());
            reading == Reading::New && number(&got) == n
        });
        // The first round allocates what the thread itself needs.
        if n == 1 {
            counted = 0;
        }
    }
    assert_eq!(counted, 0);
}
