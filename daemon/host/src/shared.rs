//! State shared by the codels, ports and remotes of one component: contexts and events.

use std::ffi::c_char;

use crate::context::Contexts;
use crate::events::Events;

/// Contexts and events of a component.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) events: Events,
    pub(crate) contexts: Contexts,
}

impl Shared {
    /// Records exception `name` in the context that a codel passed; returns the event for the
    /// codel.
    ///
    /// If the context is not the codel's own, nothing is recorded, and the event is returned all
    /// the same.
    pub(crate) fn throw(&self, context: *mut u8, name: &str, detail: &[u8]) -> *const c_char {
        let fatal = || self.events.pointer("::genom::fatal").unwrap_or(c"::genom::fatal".as_ptr());
        let Some(event) = self.events.pointer(name) else { return fatal() };
        match self.contexts.passed(context) {
            Some(context) if !context.record(event, detail) => fatal(),
            _ => event,
        }
    }
}
