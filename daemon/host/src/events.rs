//! Events of a component: strings in the library, numbers in the runtime. One of the few unsafe
//! modules.
//!
//! genom3.md 5.3: a returned event is identified by its content; for an event passed to a library,
//! the pointer is the library's own, since codels compare pointers.
#![allow(unsafe_code)]

use std::collections::HashMap;
use std::ffi::{CString, c_char, c_long};

use genom_runtime::body::EventId;

use crate::library::Library;

/// Longest event that is read from a library's memory, in bytes.
const LONGEST: usize = 1024;

/// Least size of a memory page: within one, all bytes or none can be read.
const PAGE: usize = 4096;

/// The events that a component may return or get.
#[derive(Debug)]
pub(crate) struct Events {
    ids: HashMap<Box<[u8]>, EventId>,
    /// The library's pointers, by full name; `own` holds the events that the library does not
    /// define.
    pointers: HashMap<String, usize>,
    _own: Vec<CString>,
}

impl Events {
    /// The events of `plan` by index, and those named in `given`, which the host may pass.
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

    /// The event with this content.
    pub(crate) fn id(&self, name: &[u8]) -> Option<EventId> {
        self.ids.get(name).copied()
    }

    /// The library's own pointer for event `name`; `None` when it was not prepared at load.
    pub(crate) fn pointer(&self, name: &str) -> Option<*const c_char> {
        self.pointers.get(name).map(|&at| at as *const c_char)
    }

    /// Whether the host passes this event to codels, which may return it.
    pub(crate) fn is_given(&self, event: *const c_char) -> bool {
        self.pointers.values().any(|&at| at == event as usize)
    }
}

/// C names that an event may have (genom3.md 5.3): of states as they are, of exceptions with `_id`.
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

/// Content of an event that a codel returned; empty for NULL, `None` if it cannot be read.
///
/// `known`: it lies in memory of the library, which is loaded. Any other address may be invalid:
/// the kernel is asked whether it can be read.
pub(crate) fn text<'a>(event: *const c_char, known: bool) -> Option<&'a [u8]> {
    if event.is_null() {
        return Some(&[]);
    }
    let first = event as usize;
    let mut end = first;
    while end - first < LONGEST {
        if !known && !is_readable(end) {
            return None;
        }
        let rest = PAGE - end % PAGE;
        for at in end..end + rest.min(LONGEST - (end - first)) {
            // SAFETY: an event is a NUL-terminated string (genom3.md 5.3) of a library that is
            // loaded, or this part of it was just found readable. The caller uses it before the
            // library runs again.
            if unsafe { (at as *const u8).read() } == 0 {
                // SAFETY: as above: each byte was read.
                return Some(unsafe { std::slice::from_raw_parts(event.cast(), at - first) });
            }
        }
        end += rest;
    }
    // SAFETY: as above.
    Some(unsafe { std::slice::from_raw_parts(event.cast(), LONGEST) })
}

/// Whether the 8-byte word that contains this address can be read.
fn is_readable(address: usize) -> bool {
    // The first page is never mapped, and a null mask would not be read.
    if address < PAGE {
        return false;
    }
    // The kernel reads the new mask before it rejects the unknown operation.
    let (nothing, size) = (std::ptr::null_mut::<u8>(), 8);
    // SAFETY: no mask is changed, since the operation does not exist.
    let done = unsafe {
        libc::syscall(libc::SYS_rt_sigprocmask, c_long::MAX, address & !7, nothing, size)
    };
    done == 0 || std::io::Error::last_os_error().raw_os_error() != Some(libc::EFAULT)
}

/// Numbers of events by pointer: a small cache of fixed size, private to one thread.
#[derive(Debug)]
pub(crate) struct EventCache {
    slots: [(usize, EventId); Self::SLOTS],
}

impl EventCache {
    const SLOTS: usize = 64;
    /// Slots tried for one pointer.
    const TRIES: usize = 4;

    /// An empty cache.
    pub(crate) fn new() -> Self {
        Self { slots: [(0, EventId(0)); Self::SLOTS] }
    }

    /// The event cached for this pointer.
    #[inline]
    pub(crate) fn get(&self, event: *const c_char) -> Option<EventId> {
        let slot = |rank| self.slots[rank];
        Self::slots(event).map(slot).find(|slot| slot.0 == event as usize).map(|slot| slot.1)
    }

    /// Caches the event of a pointer whose content never changes; may replace an older entry.
    pub(crate) fn note(&mut self, event: *const c_char, id: EventId) {
        let free = Self::slots(event).find(|&rank| self.slots[rank].0 == 0);
        let rank = free.or_else(|| Self::slots(event).next()).unwrap_or_default();
        self.slots[rank] = (event as usize, id);
    }

    fn slots(event: *const c_char) -> impl Iterator<Item = usize> {
        // Strings of one library lie close together and start at any byte: mix the bits.
        let at = event as usize;
        let first = at ^ (at >> 6);
        (0..Self::TRIES).map(move |i| first.wrapping_add(i) % Self::SLOTS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_read_where_there_is_some() {
        let read = |text: &str, known| {
            let text = CString::new(text).unwrap();
            super::text(text.as_ptr(), known).map(<[u8]>::to_vec)
        };
        assert_eq!(read("::demo::ether", false), Some(b"::demo::ether".to_vec()));
        assert_eq!(read(&"x".repeat(5000), false).map(|text| text.len()), Some(LONGEST));
        assert_eq!(text(std::ptr::null(), false), Some(&[][..]));
        for wild in [1, 7, 4096, 0x1234_5678_9000, usize::MAX - 8] {
            assert_eq!(text(wild as *const c_char, false), None, "{wild:x}");
        }
    }

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
