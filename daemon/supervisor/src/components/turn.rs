//! Who may exchange the library of a component: one at a time.

use std::sync::atomic::{AtomicBool, Ordering};

/// Taken by who exchanges the library of a component.
#[derive(Debug, Default)]
pub struct Turn(AtomicBool);

/// Has the turn until it is dropped.
#[derive(Debug)]
pub struct Taken<'a>(&'a Turn);

impl Turn {
    /// Takes it; `None` while somebody else has it.
    #[must_use]
    pub fn begin(&self) -> Option<Taken<'_>> {
        (!self.0.swap(true, Ordering::AcqRel)).then_some(Taken(self))
    }
}

impl Drop for Taken<'_> {
    fn drop(&mut self) {
        self.0.0.store(false, Ordering::Release);
    }
}
