//! Components by their descriptions, and limits that no machine is too slow for.

#![allow(dead_code, clippy::unwrap_used)]

use std::sync::Arc;

use genom_description::{Options, read_text};
use genom_formal::{Bounds, Limits, System};
use genom_runtime::Plan;

/// Two tasks and one exclusion: `fast` waits for `slow` at times.
pub(crate) const DUO: &str = "component duo { ids { long shared; };
  task fast { period 10 ms; codel<start> fa(inout shared) yield pause::start wcet 3 ms; };
  task slow { period 40 ms; codel<start> sb(inout shared) yield work wcet 8 ms;
    codel<work> sw() yield pause::start wcet 20 ms; }; };";

/// The system of a description; with the standard services or without.
pub(crate) fn system(text: &str, bounds: Bounds, standard_interface: bool) -> System {
    let options = Options { standard_interface, ..Options::default() };
    let analysis = read_text("small.gen", text, &options);
    assert!(!analysis.has_errors(), "{text}\n{:#?}", analysis.diagnostics);
    System::new(&Arc::new(Plan::new(&Arc::new(analysis.specification), 0).unwrap()), bounds)
}

/// The same without shutdown and standard services.
pub(crate) fn running(text: &str) -> System {
    system(text, Bounds { kill: false, ..Bounds::default() }, false)
}

/// However slow the machine is.
pub(crate) fn limits() -> Limits {
    Limits { time: std::time::Duration::MAX, ..Limits::default() }
}
