//! Hostile bytes from the network, and gateways that are ended meanwhile; by hand and for longer:
//! `cargo faults --network 300 --kills 100`.

use std::time::Duration;

use genom_tests::siege::Siege;

#[test]
fn hostile_bytes_end_no_component_and_ports_flow_again() {
    // Fails if a daemon ends, or if ports do not flow again.
    let outcome = Siege { bytes: Duration::from_secs(2), kills: 2, seed: 1 }.lay();
    assert_eq!(outcome.cell_ends, 0);
    let [datagrams, connections, sessions] = outcome.sent;
    assert!(datagrams > 100 && connections > 5 && sessions > 0, "{outcome:?}");
    let back: Vec<usize> = outcome.gateways.iter().map(|one| one.back.len()).collect();
    assert_eq!(back, [1, 1]);
}
