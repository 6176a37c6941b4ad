//! A bounded lock-free ring of indices, with one producer and one consumer.
//!
//! The indices refer to buffers that are kept elsewhere, so that samples change owner without a
//! copy. When the ring is full, the producer chooses between dropping the new index and the oldest.

use std::sync::atomic::{AtomicU64, Ordering};

/// Low bits of a slot that hold the index; the others hold the sequence number plus one.
const INDEX_BITS: u32 = 16;

/// Greatest index that a slot can hold.
pub const MAX_INDEX: usize = (1 << INDEX_BITS) - 1;

/// Value of an empty slot.
const EMPTY: u64 = 0;

/// The ring. At any time, at most one thread may push and at most one may pop.
///
/// ```
/// use genom_kit::index_ring::IndexRing;
///
/// let ring = IndexRing::new(2);
/// assert_eq!((ring.push_over(7), ring.push_over(8)), (None, None));
/// assert_eq!(ring.push_over(9), Some(7), "the oldest is given back");
/// assert!(!ring.push_if_free(10), "full");
/// assert_eq!((ring.pop(), ring.pop(), ring.pop()), (Some(8), Some(9), None));
/// ```
#[derive(Debug)]
pub struct IndexRing {
    slots: Box<[AtomicU64]>,
    /// Sequence number of the next push. Written by the producer only.
    head: AtomicU64,
    /// Sequence number of the next pop. Written by the consumer only.
    tail: AtomicU64,
}

impl IndexRing {
    /// A ring for `capacity` indices; for 1 if `capacity` is 0.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        let slots = (0..capacity.max(1)).map(|_| AtomicU64::new(EMPTY)).collect();
        Self { slots, head: AtomicU64::new(0), tail: AtomicU64::new(0) }
    }

    /// How many indices fit.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.slots.len()
    }

    fn slot(&self, sequence: u64) -> &AtomicU64 {
        &self.slots[(sequence % self.slots.len() as u64) as usize]
    }

    /// Pushes an index. When the ring is full, removes the oldest index and returns it. Wait-free.
    pub fn push_over(&self, index: usize) -> Option<usize> {
        let sequence = self.head.load(Ordering::Relaxed);
        let old = self.slot(sequence).swap(pack(sequence, index), Ordering::AcqRel);
        self.head.store(sequence + 1, Ordering::Relaxed);
        (old != EMPTY).then(|| unpack(old).1)
    }

    /// Pushes an index unless the ring is full. Returns whether it did. Wait-free.
    pub fn push_if_free(&self, index: usize) -> bool {
        let sequence = self.head.load(Ordering::Relaxed);
        let slot = self.slot(sequence);
        if slot.load(Ordering::Acquire) != EMPTY {
            return false;
        }
        slot.store(pack(sequence, index), Ordering::Release);
        self.head.store(sequence + 1, Ordering::Relaxed);
        true
    }

    /// Pops the oldest index. Retries only while the producer overwrites the slot being read.
    pub fn pop(&self) -> Option<usize> {
        let mut wanted = self.tail.load(Ordering::Relaxed);
        loop {
            let slot = self.slot(wanted);
            let found = slot.load(Ordering::Acquire);
            if found == EMPTY {
                self.tail.store(wanted, Ordering::Relaxed);
                return None;
            }
            let (sequence, index) = unpack(found);
            if sequence != wanted {
                // The producer overwrote the slot: `sequence` is one round later than the one
                // wanted.
                wanted = sequence + 1 - self.slots.len() as u64;
                continue;
            }
            let taken =
                slot.compare_exchange(found, EMPTY, Ordering::AcqRel, Ordering::Acquire).is_ok();
            if taken {
                self.tail.store(wanted + 1, Ordering::Relaxed);
                return Some(index);
            }
        }
    }
}

fn pack(sequence: u64, index: usize) -> u64 {
    ((sequence + 1) << INDEX_BITS) | index as u64
}

fn unpack(slot: u64) -> (u64, usize) {
    ((slot >> INDEX_BITS) - 1, (slot & MAX_INDEX as u64) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_full_ring_gives_up_the_oldest_or_the_newest() {
        let ring = IndexRing::new(2);
        assert_eq!(ring.push_over(1), None);
        assert_eq!(ring.push_over(2), None);
        assert!(!ring.push_if_free(9));
        assert_eq!(ring.push_over(3), Some(1));
        assert_eq!(ring.push_over(4), Some(2));
        assert_eq!(ring.push_over(5), Some(3));
        assert_eq!(ring.pop(), Some(4));
        assert!(ring.push_if_free(6));
        assert_eq!(ring.pop(), Some(5));
        assert_eq!(ring.pop(), Some(6));
        assert_eq!(ring.pop(), None);
    }
}
