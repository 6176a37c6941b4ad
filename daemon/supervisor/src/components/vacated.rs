//! Whether a library that ran is free of threads.

use std::thread;
use std::time::Duration;

use genom_host::Component;

/// How often to look: addresses that the library left on the stacks of tasks disappear when these go
/// on.
const LOOKS: u32 = 20;
/// Pause between two looks.
const LOOK: Duration = Duration::from_millis(20);

/// Whether nothing is in its code any more, after a moment of patience.
pub(crate) fn is_vacated(component: &Component) -> bool {
    (0..LOOKS).any(|_| {
        let free = !component.is_in_code();
        if !free {
            thread::park_timeout(LOOK);
        }
        free
    })
}
