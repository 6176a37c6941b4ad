//! What codels may write to, and whether they wrote past it. One of the few unsafe modules.
//!
//! Around the IDS, the inputs, outputs and local variables of each run, and the data of simple
//! ports lie zones of a known pattern. They are looked at when a codel pauses or ends, or after
//! each codel ([`check_memory`]).
#![allow(unsafe_code)]

use std::sync::atomic::{AtomicU8, Ordering};

use genom_types::{Side, TypeId, TypeTable, Zones};

/// When to look whether codels wrote past what they were given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum MemoryCheck {
    /// Never.
    Off,
    /// When a codel yields a pause, ends its activity or its service, 16 bytes on each side.
    #[default]
    Pauses,
    /// After each codel, 64 bytes on each side.
    EachCodel,
}

static MODE: AtomicU8 = AtomicU8::new(MemoryCheck::Pauses as u8);

/// Says when to look, for components that are loaded from now on.
pub fn check_memory(when: MemoryCheck) {
    MODE.store(when as u8, Ordering::Relaxed);
}

/// When to look.
pub(super) fn mode() -> MemoryCheck {
    match MODE.load(Ordering::Relaxed) {
        0 => MemoryCheck::Off,
        2 => MemoryCheck::EachCodel,
        _ => MemoryCheck::Pauses,
    }
}

/// A record or object in words.
#[derive(Clone, Debug)]
pub(super) struct Described {
    what: String,
    /// No codel gets a part of it.
    is_empty: bool,
    /// Names of the first and the last member.
    members: Option<(String, String)>,
}

impl Described {
    /// A struct of that type, and what it is.
    pub(super) fn new(what: String, types: &TypeTable, ty: TypeId) -> Self {
        let members = types.members(ty);
        let ends = members.first().zip(members.last());
        let ends = ends.map(|(first, last)| (first.name.clone(), last.name.clone()));
        Self { what, is_empty: ends.is_none(), members: ends }
    }

    /// Something without members of interest.
    pub(super) fn whole(what: String) -> Self {
        Self { what, is_empty: false, members: None }
    }

    fn beyond(&self, side: Side) -> String {
        let (beyond, member) = match side {
            Side::Past => ("past the end of", self.members.as_ref().map(|(_, last)| last)),
            Side::Before => {
                ("before the beginning of", self.members.as_ref().map(|(first, _)| first))
            }
        };
        let member = member.map(|name| format!(" (next to `{name}`)")).unwrap_or_default();
        format!("{beyond} {}{member}", self.what)
    }
}

/// Zones that one frame or component looks at.
#[derive(Debug, Default)]
pub(super) struct Watched {
    /// Apart from the words: these are looked at on every pause.
    zones: Vec<Zones>,
    described: Vec<Described>,
}

impl Watched {
    /// Watches memory too, unless it has no members to write to.
    ///
    /// # Safety
    /// What the zones belong to lives as long as this is asked.
    pub(super) unsafe fn add(&mut self, zones: Zones, described: &Described) {
        if described.is_empty {
            return;
        }
        self.zones.push(zones);
        self.described.push(described.clone());
    }

    /// Whether nobody wrote to the bytes next to any of it.
    #[inline]
    pub(super) fn is_whole_nearby(&self) -> bool {
        // SAFETY: the promise of `add`.
        self.zones.iter().all(|zones| unsafe { zones.are_whole_nearby() })
    }

    /// Where somebody wrote, in words, if anywhere. The zones are then as they were.
    #[cold]
    pub(super) fn take_written(&self) -> Option<String> {
        let found = self.zones.iter().zip(&self.described).filter_map(|(zones, described)| {
            // SAFETY: the promise of `add`.
            unsafe {
                let side = zones.written()?;
                zones.mend();
                Some(described.beyond(side))
            }
        });
        let found: Vec<_> = found.collect();
        (!found.is_empty()).then(|| found.join(", "))
    }
}
