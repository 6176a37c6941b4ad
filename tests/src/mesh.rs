//! A daemon whose graph has many connections, for the pages of the web console.
//!
//! The component is `tests/fixtures/mesh`: four in ports, two out ports, one task at 10 Hz.

use std::fmt::Write as _;
use std::path::Path;

use crate::fixture;

/// In ports of the component.
const SIDES: [&str; 4] = ["north", "east", "south", "west"];

/// Builds the component in a directory. Returns the configuration of a daemon that loads it this
/// many times, as `part00`, `part01`, ..., each connected to four others or itself: mostly to some
/// before it, and now and then to one after it.
///
/// # Panics
/// If it cannot be built.
#[must_use]
pub fn mesh(components: usize, made: &Path) -> String {
    let library = fixture("mesh", "mesh", made);
    let mut text = "backend = \"local\"\n".to_owned();
    let mut add = |more: &str| text.write_str(more).expect("a string takes all");
    for n in 0..components {
        add(&format!("[[component]]\nlibrary = {library:?}\nname = \"part{n:02}\"\n"));
    }
    let mut state: usize = 7;
    let mut some = |below: usize| {
        // A linear congruential generator: the same graph each time.
        state = state.wrapping_mul(25_214_903_917).wrapping_add(11) % (1 << 48);
        (state >> 20) % below
    };
    for n in 0..components {
        for (at, side) in SIDES.iter().enumerate() {
            let back = 1 + some(if at < 2 { 12 } else { 30 });
            let from = if some(20) == 0 { some(components) } else { n.saturating_sub(back) };
            let port = ["sum", "mean"][some(2)];
            add(&format!(
                "[[connection]]\nin = \"part{n:02}/{side}\"\nout = \"part{from:02}/{port}\"\n"
            ));
        }
    }
    text
}
