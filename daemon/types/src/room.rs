//! Memory that is lent to foreign code, between two guard zones filled with a known pattern: a
//! write past the end or before the beginning changes the pattern and damages nothing else.

use std::alloc::{self, Layout};
use std::ptr::NonNull;

/// Bytes of each zone.
const ZONE: usize = 64;
/// Content of the zones: unlikely as an address, a number or a text.
const PATTERN: u64 = 0x8d3f_a5c9_71e6_b24b;

/// Zeroed memory of a fixed size, at an address that never changes.
#[derive(Debug)]
pub struct Room {
    at: NonNull<u8>,
    size: usize,
}

// SAFETY: the memory belongs to the room alone.
unsafe impl Send for Room {}
// SAFETY: as above; with a shared reference its zones are only read.
unsafe impl Sync for Room {}

/// The side on which a zone was overwritten.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Before the beginning.
    Before,
    /// Past the end.
    Past,
}

/// Addresses of the guard zones of a room, for frequent checks.
#[derive(Clone, Copy, Debug)]
pub struct Zones {
    begin: usize,
    end: usize,
}

impl Room {
    /// Allocates `size` bytes, aligned to 16.
    #[must_use]
    pub fn new(size: usize) -> Self {
        let layout = layout(size);
        // SAFETY: the layout has a size.
        let base = unsafe { alloc::alloc_zeroed(layout) };
        if base.is_null() {
            alloc::handle_alloc_error(layout);
        }
        // SAFETY: the zone lies within the memory.
        let at = unsafe { NonNull::new_unchecked(base.add(ZONE)) };
        let room = Self { at, size };
        // SAFETY: the zones are the room's own.
        unsafe { room.zones().mend() };
        room
    }

    /// Address of the first byte between the zones.
    #[must_use]
    pub fn at(&self) -> *mut u8 {
        self.at.as_ptr()
    }

    /// Addresses of its guard zones.
    #[must_use]
    pub fn zones(&self) -> Zones {
        let begin = self.at.as_ptr() as usize;
        Zones { begin, end: begin + self.size }
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        // SAFETY: allocated in `new` with the same layout, at this address.
        unsafe { alloc::dealloc(self.at.as_ptr().sub(ZONE), layout(self.size)) };
    }
}

fn layout(size: usize) -> Layout {
    let room = size.saturating_add(2 * ZONE);
    Layout::from_size_align(room, 16).unwrap_or(Layout::new::<[u128; 8]>())
}

impl Zones {
    /// Whether the 16 bytes on either side of the room hold the pattern. Costs a nanosecond.
    ///
    /// # Safety
    /// The room has not been dropped.
    #[inline]
    #[must_use]
    pub unsafe fn are_whole_nearby(&self) -> bool {
        let word = |at: usize| {
            // SAFETY: within a zone; foreign code writes there only against the rules.
            unsafe { (at as *const u64).read_unaligned() }
        };
        (word(self.begin - 8) ^ PATTERN)
            | (word(self.begin - 16) ^ PATTERN)
            | (word(self.end) ^ PATTERN)
            | (word(self.end + 8) ^ PATTERN)
            == 0
    }

    /// The side on which the zones were overwritten; checks all their bytes.
    ///
    /// # Safety
    /// The room has not been dropped.
    #[must_use]
    pub unsafe fn written(&self) -> Option<Side> {
        let whole = |from: usize| {
            (0..ZONE).step_by(8).all(|at| {
                // SAFETY: within a zone.
                unsafe { ((from + at) as *const u64).read_unaligned() == PATTERN }
            })
        };
        if !whole(self.end) {
            return Some(Side::Past);
        }
        (!whole(self.begin - ZONE)).then_some(Side::Before)
    }

    /// Restores the pattern.
    ///
    /// # Safety
    /// The room has not been dropped.
    pub unsafe fn mend(&self) {
        for from in [self.begin - ZONE, self.end] {
            for at in (0..ZONE).step_by(8) {
                // SAFETY: within a zone, which is no part of a value.
                unsafe { ((from + at) as *mut u64).write_unaligned(PATTERN) };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_byte_past_either_end_shows_and_no_byte_within_does() {
        for size in [0, 1, 7, 8, 24, 1000] {
            let room = Room::new(size);
            let zones = room.zones();
            // SAFETY: the room lives, and its memory is from 64 bytes before to 64 bytes behind it.
            unsafe {
                assert!(zones.are_whole_nearby());
                room.at().write_bytes(0xff, size);
                assert_eq!(zones.written(), None);
                for (offset, side) in [(size, Side::Past), (size + 15, Side::Past)] {
                    room.at().add(offset).write(0);
                    assert!(!zones.are_whole_nearby());
                    assert_eq!(zones.written(), Some(side));
                    zones.mend();
                }
                room.at().sub(16).write(0);
                assert!(!zones.are_whole_nearby());
                assert_eq!(zones.written(), Some(Side::Before));
                zones.mend();
                assert!(zones.are_whole_nearby());
                // Bytes further away are seen by the full check only.
                room.at().add(size + 40).write(0);
                assert!(zones.are_whole_nearby());
                assert_eq!(zones.written(), Some(Side::Past));
            }
        }
    }
}
