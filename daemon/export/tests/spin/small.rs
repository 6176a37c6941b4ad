//! Small components.

use std::sync::Arc;

use genom_description::{Analysis, Options, read_text};
use genom_formal::{Bounds, System};
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
