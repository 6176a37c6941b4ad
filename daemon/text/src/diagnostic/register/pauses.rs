//! W095x: cycles without pause.

use super::row::{Explanation, row};

pub(super) const ROWS: &[Explanation] = &[
    row(
        "W0950",
        "",
        "a periodic task runs a cycle that never pauses",
        "States follow each other at once, within one tick, and no codel among them yields a \
         pause or anything else: the task is at work from then on, misses its ticks and keeps a \
         processor, until the activity is interrupted. Yield `pause::` and the state: the codel \
         runs again at the next tick.",
        "component demo { task main { period 5 ms; }; activity run() { task main; \
         codel<start> c() yield start; codel<stop> d() yield ether; }; };",
    ),
    row(
        "W0951",
        "",
        "a periodic task runs a cycle that only a codel's choice ends",
        "States follow each other at once, within one tick, until a codel yields another one: as \
         long as it does not, the task misses its ticks and other activities of the task wait. \
         For something that takes more than a part of the period, yield `pause::` and the state.",
        "component demo { task main { period 5 ms; }; activity run() { task main; \
         codel<start> c() yield start, ether; codel<stop> d() yield ether; }; };",
    ),
];
