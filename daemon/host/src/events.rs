//! Events of a component: strings to the library, numbers to the runtime. One of the few unsafe
//! modules.
//!
//! genom3.md 5.3: a returned event is known by its contents, and one handed to a library is the
//! pointer that this library itself compares with.
#![allow(unsafe_code)]

use std::collections::HashMap;
use std::ffi::{CStr, CString, c_char};

use genom_runtime::body::EventId;

use crate::library::Library;

/// Longest event that is read from a library's memory.
const LONGEST: usize = 1024;

/// The events a component may return or be given.
#[derive(Debug)]
pub(crate) struct Events {
    ids: HashMap<Box<[u8]>, EventId>,
    /// Pointers for the library, by full name; `own` holds those it does not define.
    pointers: HashMap<String, usize>,
    _own: Vec<CString>,
}

impl Events {
    /// The events of `plan` by rank, and the names in `given` that the host may hand out.
    pub(crate) fn new<'a>(
        library: &Library,
        plan: impl Iterator<Item = &'a str>,
        given: impl Iterator<Item = &'a str>,
    ) -> Self {
        let mut events = Self { ids: HashMap::new(), pointers: HashMap::new(), _own: Vec::new() };
        for (rank, name) in (0_u16..).zip(plan) {
            events.ids.insert(name.as_bytes().into(), EventId(rank));
        }
        for name in given {
            let Ok(text) = CString::new(name) else { continue };
            let found = symbols_of(name).into_iter().find_map(|symbol| {
                library.symbol(&symbol).filter(|&at| holds(at, text.as_bytes_with_nul()))
            });
            let pointer = found.unwrap_or(text.as_ptr() as usize);
            events.pointers.insert(name.to_owned(), pointer);
            events._own.push(text);
        }
        events
    }

    /// The event of this content.
    pub(crate) fn id(&self, name: &[u8]) -> Option<EventId> {
        self.ids.get(name).copied()
    }

    /// The library's own pointer for event `name`; `None` when it was not announced at load.
    pub(crate) fn pointer(&self, name: &str) -> Option<*const c_char> {
        self.pointers.get(name).map(|&at| at as *const c_char)
    }
}

/// C names an event may have (genom3.md 5.3): states as they are, exceptions with `_id`.
fn symbols_of(name: &str) -> [String; 2] {
    let plain = name.trim_start_matches("::").replace("::", "_");
    [format!("{plain}_id"), plain]
}

/// Whether the memory at `at`, an exported symbol, begins with `bytes`.
fn holds(at: usize, bytes: &[u8]) -> bool {
    // SAFETY: a symbol has at least one byte, and reading stops at the first that differs; a
    // string that agrees so far goes on at least to its NUL.
    bytes.iter().enumerate().all(|(i, byte)| unsafe { (at as *const u8).add(i).read() } == *byte)
}

/// Contents of an event that a codel returned; empty for NULL.
pub(crate) fn contents<'a>(event: *const c_char) -> &'a [u8] {
    if event.is_null() {
        return &[];
    }
    // SAFETY: an event is a NUL-terminated string (genom3.md 5.3) of a library that is loaded, and
    // the caller looks at it before the library runs again.
    let bytes = unsafe { CStr::from_ptr(event) }.to_bytes();
    &bytes[..bytes.len().min(LONGEST)]
}

/// Numbers of events by pointer: a small table that never grows, private to one thread.
#[derive(Debug)]
pub(crate) struct EventCache {
    slots: [(usize, EventId); Self::SLOTS],
}

impl EventCache {
    const SLOTS: usize = 64;
    /// Slots tried for one pointer.
    const TRIES: usize = 4;

    /// An empty one.
    pub(crate) fn new() -> Self {
        Self { slots: [(0, EventId(0)); Self::SLOTS] }
    }

    /// The event last noted for this pointer.
    #[inline]
    pub(crate) fn get(&self, event: *const c_char) -> Option<EventId> {
        let slot = |rank| self.slots[rank];
        Self::slots(event).map(slot).find(|slot| slot.0 == event as usize).map(|slot| slot.1)
    }

    /// Notes the event of a pointer whose contents never change; an older note may go.
    pub(crate) fn note(&mut self, event: *const c_char, id: EventId) {
        let free = Self::slots(event).find(|&rank| self.slots[rank].0 == 0);
        let rank = free.or_else(|| Self::slots(event).next()).unwrap_or_default();
        self.slots[rank] = (event as usize, id);
    }

    fn slots(event: *const c_char) -> impl Iterator<Item = usize> {
        // Strings of one library lie close together and start at any byte.
        let at = event as usize;
        let first = at ^ (at >> 6);
        (0..Self::TRIES).map(move |i| first.wrapping_add(i) % Self::SLOTS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cache_knows_what_was_noted_and_forgets_rather_than_confuses() {
        let mut cache = EventCache::new();
        let text = [0_u8; 1000];
        let pointer = |i: usize| text[i..].as_ptr().cast::<c_char>();
        assert_eq!(cache.get(pointer(0)), None);
        for i in 0..1000_u16 {
            cache.note(pointer(i.into()), EventId(i));
            assert_eq!(cache.get(pointer(i.into())), Some(EventId(i)));
        }
        for i in 0..1000_u16 {
            assert!(cache.get(pointer(i.into())).is_none_or(|id| id == EventId(i)));
        }
    }
}
