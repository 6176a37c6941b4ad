//! A bounded queue between two threads that reuses its buffers.
//!
//! For outgoing samples the real-time thread puts and the middleware takes; for incoming samples
//! the other way round. Neither side waits for the other.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rustix::time::{ClockId, clock_gettime};

use crate::index_ring::{IndexRing, MAX_INDEX};

/// Greatest number of messages that a mailbox can hold.
pub const MAX_DEPTH: usize = MAX_INDEX - 2;

/// Which message is dropped when the mailbox is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Full {
    /// The oldest message.
    Oldest,
    /// The new one.
    Newest,
}

/// The queue. At any time, at most one thread may put and at most one may take; the caller must
/// ensure this.
///
/// ```
/// use genom_kit::mailbox::{Full, Mailbox};
///
/// // Two messages, with buffers of 16 bytes; when full, the oldest is dropped.
/// let mailbox: Mailbox = Mailbox::new(2, 16, Full::Oldest);
/// for n in [1, 2, 3] {
///     mailbox.put(|buffer| { buffer.push(n); Ok::<(), ()>(()) }).unwrap();
/// }
/// assert_eq!(mailbox.lost(), 1);
/// assert_eq!(mailbox.take(|message| message[0]), Some(2));
/// ```
#[derive(Debug)]
pub struct Mailbox<T = Vec<u8>> {
    /// Two more than the ring holds: one that the producer fills and one that the consumer reads.
    slots: Box<[Slot<T>]>,
    ring: IndexRing,
    full: Full,
    lost: AtomicU64,
    /// Whether messages are dated; see [`dated`](Mailbox::dated).
    dated: bool,
    /// When the message was put that was taken last; 0 for none.
    taken: AtomicU64,
    /// Where the search for a free slot starts: at the one freed last, which is likely still in the
    /// cache.
    hint: AtomicU64,
}

#[derive(Debug)]
struct Slot<T> {
    /// Never contended: while a slot is free, only the producer uses it; afterwards only the thread
    /// that holds its index. The lock exists to avoid unsafe code.
    message: Mutex<T>,
    used: AtomicBool,
    /// When it was put.
    date: AtomicU64,
}

/// A message was not added.
#[derive(Debug)]
pub enum PutError<E> {
    /// No slot is free. Cannot happen with one producer and one consumer.
    Busy,
    /// The error that `fill` returned.
    Fill(E),
}

impl Mailbox {
    /// A mailbox for `depth` messages, whose buffers are allocated with `size` bytes each.
    #[must_use]
    pub fn new(depth: usize, size: usize, full: Full) -> Self {
        Self::with(depth, full, || Vec::with_capacity(size))
    }

    /// Adds a message that `fill` writes into an empty buffer. Wait-free; allocates nothing if the
    /// buffer is large enough.
    ///
    /// # Errors
    /// What `fill` returned; no message was added then.
    pub fn put<E>(
        &self,
        fill: impl FnOnce(&mut Vec<u8>) -> Result<(), E>,
    ) -> Result<(), PutError<E>> {
        self.put_by(|message| {
            message.clear();
            fill(message)
        })
    }

    /// Swaps the oldest message with an empty buffer. Returns whether there was a message.
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
    /// A mailbox for `depth` messages whose slots are initialised by `make`.
    #[must_use]
    pub fn with(depth: usize, full: Full, make: impl Fn() -> T) -> Self {
        let depth = depth.clamp(1, MAX_DEPTH);
        let slot = || Slot {
            message: Mutex::new(make()),
            used: AtomicBool::new(false),
            date: AtomicU64::new(0),
        };
        Self {
            slots: (0..depth + 2).map(|_| slot()).collect(),
            ring: IndexRing::new(depth),
            full,
            lost: AtomicU64::new(0),
            dated: false,
            taken: AtomicU64::new(0),
            hint: AtomicU64::new(0),
        }
    }

    /// The same mailbox, which remembers when messages were put.
    #[must_use]
    pub fn dated(self) -> Self {
        Self { dated: true, ..self }
    }

    /// When the message was put that was taken last, on `CLOCK_MONOTONIC` in nanoseconds; `None`
    /// before the first, or if the mailbox is not [`dated`](Self::dated).
    #[must_use]
    pub fn put_at(&self) -> Option<u64> {
        Some(self.taken.load(Ordering::Relaxed)).filter(|date| *date > 0)
    }

    /// Number of messages dropped so far.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Adds a message that `fill` makes by overwriting an old one, and returns what `fill`
    /// returned. Wait-free.
    ///
    /// # Errors
    /// What `fill` returned; no message was added then.
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
        if self.dated {
            slot.date.store(now(), Ordering::Relaxed);
        }
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

    /// Takes the oldest message, if there is one, and passes it to `see`.
    pub fn take<R>(&self, see: impl FnOnce(&T) -> R) -> Option<R> {
        let index = self.ring.pop()?;
        let slot = self.slots.get(index)?;
        self.taken.store(slot.date.load(Ordering::Relaxed), Ordering::Relaxed);
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

fn now() -> u64 {
    let now = clock_gettime(ClockId::Monotonic);
    now.tv_sec.unsigned_abs() * 1_000_000_000 + now.tv_nsec.unsigned_abs()
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
    fn a_dated_mailbox_tells_when_the_message_arrived_that_was_taken() {
        let mailbox = Mailbox::new(2, 8, Full::Oldest).dated();
        assert_eq!(mailbox.put_at(), None);
        let before = now();
        put(&mailbox, 1);
        let between = now();
        put(&mailbox, 2);
        assert_eq!(mailbox.put_at(), None, "it was not taken");
        mailbox.take(|_| ()).unwrap();
        let first = mailbox.put_at().unwrap();
        assert!((before..=between).contains(&first), "{before} {first} {between}");
        mailbox.take(|_| ()).unwrap();
        assert!(mailbox.put_at().unwrap() >= between);
        let other = Mailbox::new(2, 8, Full::Oldest);
        put(&other, 1);
        other.take(|_| ()).unwrap();
        assert_eq!(other.put_at(), None);
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
