//! State shared by the codels, ports and remotes of one component: contexts and events. One of the
//! few unsafe modules.
#![allow(unsafe_code)]

use std::ffi::c_char;

use crate::context::Contexts;
use crate::events::Events;
use crate::exchanged::Exchanged;

/// Contexts and events of a component.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) events: Exchanged<Events>,
    pub(crate) contexts: Contexts,
}

impl Shared {
    /// Exchanges what of this comes from the library with that of another component.
    ///
    /// # Safety
    /// No codel of the two runs; the other one drops its events only when no thread of their
    /// library is left.
    pub(crate) unsafe fn exchange(&self, other: &Self) {
        // SAFETY: the caller's promise.
        unsafe {
            self.events.swap(&other.events);
            self.contexts.exchange(&other.contexts);
        }
    }

    /// Records exception `name` in the context that a codel passed; returns the event for the
    /// codel.
    ///
    /// If the context is not the codel's own, nothing is recorded, and the event is returned all
    /// the same.
    pub(crate) fn throw(&self, context: *mut u8, name: &str, detail: &[u8]) -> *const c_char {
        let events = self.events.get();
        let fatal = || events.pointer("::genom::fatal").unwrap_or(c"::genom::fatal".as_ptr());
        let Some(event) = events.pointer(name) else { return fatal() };
        match self.contexts.passed(context) {
            Some(context) if !context.record(event, detail) => fatal(),
            _ => event,
        }
    }
}
