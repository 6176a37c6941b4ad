//! Numbers of states and zones that `docs/verify.md` compares with those of an earlier prototype of
//! the rules, so that the table there stays true. Those of two tasks are in `times.rs`.

#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use genom_description::{Options, read};
use genom_formal::{Bounds, Limits, Property, System};
use genom_runtime::Plan;

/// However slow the machine is.
fn limits() -> Limits {
    Limits { time: Duration::MAX, ..Limits::default() }
}

/// The demo without shutdown; so many requests at a time.
fn demo(requests: usize) -> System {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let analysis = read(&[root.join("components/demo/demo.gen")], &Options::default());
    assert!(!analysis.has_errors(), "{:#?}", analysis.diagnostics);
    let plan = Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap());
    System::new(&plan, Bounds { kill: false, requests, ..Bounds::default() })
}

#[test]
fn the_demo_has_as_many_states_and_zones_as_the_documentation_says() {
    for (requests, states, timed) in [(1, 3861, (2870, 2870)), (2, 18_649, (14_160, 14_160))] {
        let system = demo(requests);
        let report = system.check(&[Property::Exclude], &limits());
        let explored = report.explored.unwrap();
        assert_eq!(explored.limit, None);
        let mut times = system.declared_times();
        times.bound_others(1_000_000);
        let zones = system.check_times(&times, &limits());
        assert_eq!(zones.limit(), None);
        assert_eq!(explored.states, states);
        assert_eq!((zones.explored.states(), zones.explored.zones()), timed);
        assert!(zones.tasks[0].is_late());
    }
}
