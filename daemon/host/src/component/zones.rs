//! Detects writes past the memory that codels are given. One of the few unsafe modules.
//!
//! Guard zones with a known pattern surround the IDS, the inputs, outputs and local variables of
//! each run, and the data of simple ports. They are checked when a codel pauses or ends, or after
//! each codel ([`check_memory`]).
#![allow(unsafe_code)]

use std::sync::atomic::{AtomicU8, Ordering};

use genom_types::{Side, TypeId, TypeTable, Zones};

/// When guard zones are checked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub enum MemoryCheck {
    /// Never.
    Off,
    /// When a codel yields a pause or ends its activity or service: 16 bytes on each side.
    #[default]
    Pauses,
    /// After each codel, 64 bytes on each side.
    EachCodel,
}

static MODE: AtomicU8 = AtomicU8::new(MemoryCheck::Pauses as u8);

/// Sets when guard zones are checked, for components loaded from now on.
pub fn check_memory(when: MemoryCheck) {
    MODE.store(when as u8, Ordering::Relaxed);
}

/// When guard zones are checked.
pub(super) fn mode() -> MemoryCheck {
    match MODE.load(Ordering::Relaxed) {
        0 => MemoryCheck::Off,
        2 => MemoryCheck::EachCodel,
        _ => MemoryCheck::Pauses,
    }
}

/// Description of a record or object, for messages.
#[derive(Clone, Debug)]
pub(super) struct Described {
    what: String,
    /// It has no members, so codels get no address in it.
    is_empty: bool,
    /// Names of the first and the last member.
    members: Option<(String, String)>,
}

impl Described {
    /// Describes a struct of that type.
    pub(super) fn new(what: String, types: &TypeTable, ty: TypeId) -> Self {
        let members = types.members(ty);
        let ends = members.first().zip(members.last());
        let ends = ends.map(|(first, last)| (first.name.clone(), last.name.clone()));
        Self { what, is_empty: ends.is_none(), members: ends }
    }

    /// Describes something without naming members.
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

/// Guard zones that one frame or component checks.
#[derive(Debug, Default)]
pub(super) struct Watched {
    /// Apart from the descriptions, since these are read at every pause.
    zones: Vec<Zones>,
    described: Vec<Described>,
}

impl Watched {
    /// Adds zones, unless what they surround has no members to write to.
    ///
    /// # Safety
    /// The memory that the zones surround lives as long as this is used.
    pub(super) unsafe fn add(&mut self, zones: Zones, described: &Described) {
        if described.is_empty {
            return;
        }
        self.zones.push(zones);
        self.described.push(described.clone());
    }

    /// Whether the bytes directly before and after all of it are unchanged.
    #[inline]
    pub(super) fn is_whole_nearby(&self) -> bool {
        // SAFETY: guaranteed to `add`.
        self.zones.iter().all(|zones| unsafe { zones.are_whole_nearby() })
    }

    /// Description of where something was written, if anywhere. Restores the zones.
    #[cold]
    pub(super) fn take_written(&self) -> Option<String> {
        let found = self.zones.iter().zip(&self.described).filter_map(|(zones, described)| {
            // SAFETY: guaranteed to `add`.
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
