//! What an instance has of its library: exchanged with it, while the memory stays.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_description::model::{CodelIx, Indexed};

use crate::library::Library;

/// The functions of a library, and the library.
pub(super) struct Code {
    /// The codels of the model; `None` for those that the runtime supplies.
    pub(super) functions: Indexed<CodelIx, Option<Placed>>,
    pub(super) library: Library,
    /// Of this code only: what is remembered of one library is wrong for the next one, which may
    /// lie at the same addresses.
    pub(super) number: u64,
}

/// A codel in a library.
#[derive(Debug)]
pub(super) struct Placed {
    /// Address of the C function.
    pub(super) at: usize,
    /// Description of the codel for the report if it ends the process.
    pub(super) words: String,
}

impl Code {
    pub(super) fn new(functions: Indexed<CodelIx, Option<Placed>>, library: Library) -> Self {
        static LAST: AtomicU64 = AtomicU64::new(0);
        Self { functions, library, number: LAST.fetch_add(1, Ordering::Relaxed) + 1 }
    }
}
