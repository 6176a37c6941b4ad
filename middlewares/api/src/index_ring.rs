//! A bounded ring of indices between one producer and one consumer, without locks.
//!
//! It holds small numbers that name buffers kept elsewhere, so that samples change hands without
//! being copied. When it is full the producer chooses: give up the new one, or the oldest.

use std::sync::atomic::{AtomicU64, Ordering};

/// Bits of a slot that hold the index; the rest is the sequence number plus one.
const INDEX_BITS: u32 = 16;

/// Greatest index that fits.
pub const MAX_INDEX: usize = (1 << INDEX_BITS) - 1;

/// Nothing in the slot.
const EMPTY: u64 = 0;

/// The slots. [`Producer`] and [`Consumer`] hold each side's position.
#[derive(Debug)]
pub struct IndexRing {
    slots: Box<[AtomicU64]>,
}

/// The producer's position.
#[derive(Debug, Default)]
pub struct Producer {
    next: u64,
}

/// The consumer's position.
#[derive(Debug, Default)]
pub struct Consumer {
    next: u64,
}

impl IndexRing {
    /// A ring for `capacity` indices, at least one.
    #[must_use]
    pub fn new(capacity: usize) -> Self {
        Self { slots: (0..capacity.max(1)).map(|_| AtomicU64::new(EMPTY)).collect() }
    }

    /// How many indices fit.
    #[must_use]
    pub fn capacity(&self) -> usize {
        self.slots.len()
    }

    fn slot(&self, sequence: u64) -> &AtomicU64 {
        &self.slots[(sequence % self.slots.len() as u64) as usize]
    }

    /// Adds an index; when full, gives back the oldest one, which is lost. Wait-free.
    pub fn push_over(&self, producer: &mut Producer, index: usize) -> Option<usize> {
        let sequence = producer.next;
        producer.next += 1;
        let old = self.slot(sequence).swap(pack(sequence, index), Ordering::AcqRel);
        (old != EMPTY).then(|| unpack(old).1)
    }

    /// Adds an index unless the ring is full; whether it did. Wait-free.
    pub fn push_if_free(&self, producer: &mut Producer, index: usize) -> bool {
        let slot = self.slot(producer.next);
        if slot.load(Ordering::Acquire) != EMPTY {
            return false;
        }
        slot.store(pack(producer.next, index), Ordering::Release);
        producer.next += 1;
        true
    }

    /// Takes the oldest index. Retries only while the producer overwrites what it looks at.
    pub fn pop(&self, consumer: &mut Consumer) -> Option<usize> {
        loop {
            let slot = self.slot(consumer.next);
            let found = slot.load(Ordering::Acquire);
            if found == EMPTY {
                return None;
            }
            let (sequence, index) = unpack(found);
            if sequence != consumer.next {
                // Overwritten: `sequence` replaced the one a whole round before it.
                consumer.next = sequence + 1 - self.slots.len() as u64;
                continue;
            }
            let taken =
                slot.compare_exchange(found, EMPTY, Ordering::AcqRel, Ordering::Acquire).is_ok();
            if taken {
                consumer.next += 1;
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
        let (mut producer, mut consumer) = (Producer::default(), Consumer::default());
        assert_eq!(ring.push_over(&mut producer, 1), None);
        assert_eq!(ring.push_over(&mut producer, 2), None);
        assert!(!ring.push_if_free(&mut producer, 9));
        assert_eq!(ring.push_over(&mut producer, 3), Some(1));
        assert_eq!(ring.push_over(&mut producer, 4), Some(2));
        assert_eq!(ring.push_over(&mut producer, 5), Some(3));
        assert_eq!(ring.pop(&mut consumer), Some(4));
        assert!(ring.push_if_free(&mut producer, 6));
        assert_eq!(ring.pop(&mut consumer), Some(5));
        assert_eq!(ring.pop(&mut consumer), Some(6));
        assert_eq!(ring.pop(&mut consumer), None);
    }
}
