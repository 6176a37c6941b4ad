//! Small components.

use std::sync::Arc;

use genom_description::{Analysis, Options, read_text};
use genom_formal::{Bounds, Duration, System, Times};
use genom_runtime::Plan;

use super::components::component;
use super::random::Random;

/// The system of a description; with the standard services or without.
pub(crate) fn system(text: &str, bounds: Bounds, standard_interface: bool) -> System {
    let options = Options { standard_interface, ..Options::default() };
    made(read_text("small.gen", text, &options), bounds)
}

/// The system of a description that was read.
pub(crate) fn made(analysis: Analysis, bounds: Bounds) -> System {
    assert!(!analysis.has_errors(), "{:#?}", analysis.diagnostics);
    System::new(&Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap()), bounds)
}

/// The system of a random component, with random bounds.
pub(crate) fn random(seed: u64) -> System {
    let mut random = Random(seed);
    let text = component(&mut random);
    let bounds = Bounds {
        instances: 1 + random.below(2),
        requests: 1 + random.below(2),
        slots: 1 + random.below(3),
        abort: random.percent(50),
        fire: random.percent(50),
        kill: random.percent(50),
    };
    system(&text, bounds, true)
}

/// A random component with random times, in whole milliseconds.
pub(crate) fn timed(seed: u64) -> (System, Times) {
    const MS: u64 = 1_000_000;
    let system = random(seed);
    let bounds = Bounds { kill: false, instances: 1, requests: 1, fire: false, ..*system.bounds() };
    let system = System::new(system.plan(), bounds);
    let (mut times, mut random) = (system.declared_times(), Random(seed));
    for codel in system.plan().component().codels.iter() {
        let most = u64::try_from(random.below(4)).unwrap();
        let least = if random.percent(30) { most / 2 } else { 0 };
        let duration = Duration { least: least * MS, most: Some(most * MS) };
        times.set(system.plan().component(), &codel.name, duration);
    }
    (system, times)
}

/// Two tasks that share data, with times of their codels: `sb` takes so many milliseconds at most.
#[allow(dead_code, reason = "the benches have no use for it")]
pub(crate) fn two_tasks(most: u64) -> (System, Times) {
    const MS: u64 = 1_000_000;
    let text = "component duo { ids { long shared; };
      task fast { period 10 ms; codel<start> fa(inout shared) yield pause::start; };
      task slow { period 40 ms; codel<start> sb(inout shared) yield work;
        codel<work> sw() yield pause::start; }; };";
    let system = system(text, Bounds { kill: false, ..Bounds::default() }, false);
    let mut times = system.declared_times();
    for (codel, most) in [("fa", 3), ("sb", most), ("sw", 20)] {
        let duration = Duration { least: MS, most: Some(most * MS) };
        assert!(times.set(system.plan().component(), codel, duration));
    }
    (system, times)
}
