//! A bounded queue between two threads, whose buffers are used again and again.
//!
//! Outgoing, the real-time writer fills and the middleware empties; incoming, the middleware
//! fills and the real-time reader empties. Neither side waits for the other.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use crate::index_ring::{IndexRing, MAX_INDEX};

/// Greatest number of messages a mailbox holds.
pub const MAX_DEPTH: usize = MAX_INDEX - 2;

/// What gives way in a full mailbox.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Full {
    /// The oldest message.
    Oldest,
    /// The new one.
    Newest,
}

/// One producer and one consumer at a time: the caller has to see to it.
#[derive(Debug)]
pub struct Mailbox<T = Vec<u8>> {
    /// Two more than the ring holds: one in the producer's hands, one in the consumer's.
    slots: Box<[Slot<T>]>,
    ring: IndexRing,
    full: Full,
    lost: AtomicU64,
    /// Where the search for a free slot starts: at the one released last, whose memory is warm.
    hint: AtomicU64,
}

#[derive(Debug)]
struct Slot<T> {
    /// Never contended: a slot belongs to the producer while free, then to who took its index.
    /// The lock is there so that this needs no unsafe code.
    message: Mutex<T>,
    used: AtomicBool,
}

/// A message did not get in.
#[derive(Debug)]
pub enum PutError<E> {
    /// No slot is free, which one producer and one consumer cannot bring about.
    Busy,
    /// The caller's own.
    Fill(E),
}

impl Mailbox {
    /// A mailbox of `depth` messages, each with room for `size` bytes beforehand.
    #[must_use]
    pub fn new(depth: usize, size: usize, full: Full) -> Self {
        Self::with(depth, full, || Vec::with_capacity(size))
    }

    /// Adds a message that `fill` writes into an empty buffer. Wait-free; nothing is allocated
    /// when the buffer is large enough.
    ///
    /// # Errors
    /// What `fill` says; nothing was added then.
    pub fn put<E>(
        &self,
        fill: impl FnOnce(&mut Vec<u8>) -> Result<(), E>,
    ) -> Result<(), PutError<E>> {
        self.put_by(|message| {
            message.clear();
            fill(message)
        })
    }

    /// Exchanges the oldest message for an empty buffer; whether there was one.
    pub fn exchange(&self, buffer: &mut Vec<u8>) -> bool {
        let Some(index) = self.ring.pop() else { return false };
        let Some(slot) = self.slots.get(index) else { return false };
        let taken =
            slot.message.try_lock().map(|mut message| std::mem::swap(&mut *message, buffer));
        self.release(index);
        taken.is_ok()
    }
}

impl<T> Mailbox<T> {
    /// A mailbox of `depth` messages, with what `make` makes in the places of messages to come.
    #[must_use]
    pub fn with(depth: usize, full: Full, make: impl Fn() -> T) -> Self {
        let depth = depth.clamp(1, MAX_DEPTH);
        let slot = || Slot { message: Mutex::new(make()), used: AtomicBool::new(false) };
        Self {
            slots: (0..depth + 2).map(|_| slot()).collect(),
            ring: IndexRing::new(depth),
            full,
            lost: AtomicU64::new(0),
            hint: AtomicU64::new(0),
        }
    }

    /// Messages that gave way so far.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Adds a message that `fill` makes of an old one, and gives what `fill` gives. Wait-free.
    ///
    /// # Errors
    /// What `fill` says; nothing was added then.
    pub fn put_by<R, E>(
        &self,
        fill: impl FnOnce(&mut T) -> Result<R, E>,
    ) -> Result<R, PutError<E>> {
        let count = self.slots.len();
        let start = self.hint.load(Ordering::Relaxed) as usize;
        let free = (0..count).map(|i| (start + i) % count).find_map(|index| {
            let slot = self.slots.get(index)?;
            (!slot.used.load(Ordering::Acquire)).then_some((index, slot))
        });
        let (index, slot) = free.ok_or(PutError::Busy)?;
        let mut message = slot.message.try_lock().map_err(|_| PutError::Busy)?;
        let given = fill(&mut message).map_err(PutError::Fill)?;
        drop(message);
        slot.used.store(true, Ordering::Release);
        self.hint.store((index + 1) as u64, Ordering::Relaxed);
        let gone = match self.full {
            Full::Oldest => self.ring.push_over(index),
            Full::Newest => (!self.ring.push_if_free(index)).then_some(index),
        };
        if let Some(gone) = gone {
            self.release(gone);
            self.lost.fetch_add(1, Ordering::Relaxed);
        }
        Ok(given)
    }

    /// Gives the oldest message to `see`, if there is one.
    pub fn take<R>(&self, see: impl FnOnce(&T) -> R) -> Option<R> {
        let index = self.ring.pop()?;
        let slot = self.slots.get(index)?;
        let seen = slot.message.try_lock().ok().map(|message| see(&message));
        self.release(index);
        seen
    }

    fn release(&self, index: usize) {
        if let Some(slot) = self.slots.get(index) {
            slot.used.store(false, Ordering::Release);
            self.hint.store(index as u64, Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn put(mailbox: &Mailbox, byte: u8) {
        let put = mailbox.put(|message| {
            assert!(message.is_empty());
            message.push(byte);
            Ok::<_, ()>(())
        });
        assert!(put.is_ok());
    }

    fn rest(mailbox: &Mailbox) -> Vec<u8> {
        std::iter::from_fn(|| mailbox.take(|message| message[0])).collect()
    }

    #[test]
    fn a_full_mailbox_gives_up_the_oldest_or_the_newest_and_counts() {
        for (full, kept) in [(Full::Oldest, [3, 4, 5]), (Full::Newest, [1, 2, 3])] {
            let mailbox = Mailbox::new(3, 8, full);
            (1..=5).for_each(|byte| put(&mailbox, byte));
            assert_eq!(rest(&mailbox), kept);
            assert_eq!(mailbox.lost(), 2);
        }
    }

    #[test]
    fn the_producer_goes_on_while_the_consumer_holds_a_message() {
        let mailbox = Mailbox::new(1, 8, Full::Oldest);
        put(&mailbox, 1);
        let held = mailbox.take(|message| {
            (2..100).for_each(|byte| put(&mailbox, byte));
            message[0]
        });
        assert_eq!(held, Some(1));
        assert_eq!(rest(&mailbox), [99]);
    }

    #[test]
    fn a_message_that_cannot_be_filled_leaves_no_trace() {
        let mailbox = Mailbox::new(2, 8, Full::Oldest);
        let refused = mailbox.put(|message| {
            message.push(9);
            Err("no")
        });
        assert!(matches!(refused, Err(PutError::Fill("no"))));
        put(&mailbox, 1);
        assert_eq!(rest(&mailbox), [1]);
    }
}
