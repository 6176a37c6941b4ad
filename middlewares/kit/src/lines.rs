//! The out ports that a sending thread serves, and which of them have something to send.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use crate::busy::Busy;

/// Number of words in the bit set of lines that have something to send.
const WORDS: usize = 64;

/// Number of bits in the set. With more lines than bits, several share one.
const BITS: usize = WORDS * 64;

/// Messages sent in a row for one line before it is the next one's turn.
const TURN: usize = 8;

/// An out port as the sending thread sees it.
pub trait Line: Send + 'static {
    /// Sends one message if there is one. Returns whether there was.
    fn send(&mut self) -> bool;
}

/// All lines, by number.
#[derive(Debug)]
pub struct Lines<L> {
    slots: Mutex<Slots<L>>,
    /// Signalled when a thread returns a line.
    back: Condvar,
    /// Bit set, written by real-time threads without a lock.
    marked: Box<[AtomicU64]>,
}

#[derive(Debug)]
struct Slots<L> {
    all: Vec<Slot<L>>,
    free: Vec<usize>,
}

#[derive(Debug)]
enum Slot<L> {
    Empty,
    Here(L),
    /// A thread is using it.
    Out,
}

/// A line that one thread is using. Dropping this returns the line.
#[derive(Debug)]
struct Taken<'a, L> {
    lines: &'a Lines<L>,
    number: usize,
    line: Option<L>,
}

impl<L> Drop for Taken<'_, L> {
    fn drop(&mut self) {
        let Some(line) = self.line.take() else { return };
        if let Some(slot) = self.lines.lock().all.get_mut(self.number) {
            *slot = Slot::Here(line);
        }
        self.lines.back.notify_all();
    }
}

impl<L> Lines<L> {
    pub(crate) fn new() -> Self {
        Self {
            slots: Mutex::new(Slots { all: Vec::new(), free: Vec::new() }),
            back: Condvar::new(),
            marked: (0..WORDS).map(|_| AtomicU64::new(0)).collect(),
        }
    }

    fn lock(&self) -> MutexGuard<'_, Slots<L>> {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds a line and returns its number.
    pub(crate) fn add(&self, line: L) -> usize {
        let mut slots = self.lock();
        let number = slots.free.pop().unwrap_or(slots.all.len());
        match slots.all.get_mut(number) {
            Some(slot) => *slot = Slot::Here(line),
            None => slots.all.push(Slot::Here(line)),
        }
        number
    }

    /// Removes a line, after waiting until no thread uses it. Its number stays in use until
    /// [`free`](Lines::free).
    pub(crate) fn remove(&self, number: usize) -> Option<L> {
        self.take(number, true)?.line.take()
    }

    /// Allows the number to be used for another line.
    pub(crate) fn free(&self, number: usize) {
        let mut slots = self.lock();
        if let Some(slot) = slots.all.get_mut(number) {
            *slot = Slot::Empty;
            slots.free.push(number);
        }
        drop(slots);
        self.back.notify_all();
    }

    /// Drops all lines.
    pub(crate) fn clear(&self) {
        let all = std::mem::take(&mut self.lock().all);
        // Drop them after releasing the lock: their destructors may use the lines.
        drop(all);
    }

    /// Calls `work` with a line, after waiting until no other thread uses it.
    pub fn with<R>(&self, number: usize, work: impl FnOnce(&mut L) -> R) -> Option<R> {
        self.take(number, true)?.line.as_mut().map(work)
    }

    /// Calls `wanted` for one line after the other until it returns something.
    pub fn find<R>(&self, mut wanted: impl FnMut(&mut L) -> Option<R>) -> Option<R> {
        let count = self.lock().all.len();
        (0..count).find_map(|number| self.with(number, &mut wanted).flatten())
    }

    /// Takes a line for a while. If another thread uses it, waits for it or returns `None`, by
    /// `wait`.
    fn take(&self, number: usize, wait: bool) -> Option<Taken<'_, L>> {
        let mut slots = self.lock();
        loop {
            let slot = slots.all.get_mut(number)?;
            match slot {
                Slot::Empty => return None,
                Slot::Here(_) => {
                    let Slot::Here(line) = std::mem::replace(slot, Slot::Out) else { return None };
                    return Some(Taken { lines: self, number, line: Some(line) });
                }
                Slot::Out if wait => {
                    slots = self.back.wait(slots).unwrap_or_else(PoisonError::into_inner);
                }
                Slot::Out => return None,
            }
        }
    }

    /// Marks a line as having something to send. Wait-free.
    pub(crate) fn mark(&self, number: usize) {
        if let Some(word) = self.marked.get(number % BITS / 64) {
            word.fetch_or(1 << (number % 64), Ordering::Release);
        }
    }
}

/// State of the lines of one bit after their turn.
#[derive(Clone, Copy, Debug, Default)]
struct Rest {
    /// Some may have more to send.
    more: bool,
    /// Another thread is using one of them, which may have more to send by now.
    elsewhere: bool,
}

impl<L: Line> Lines<L> {
    /// Sends for all marked lines. Returns whether some may have more to send.
    pub(crate) fn send(&self, busy: &Busy) -> bool {
        let mut more = false;
        for (index, word) in self.marked.iter().enumerate() {
            // Most words are zero, and a plain load costs less than an atomic exchange.
            let mut bits = word.load(Ordering::Relaxed);
            while bits != 0 {
                let mask = bits & bits.wrapping_neg();
                bits &= !mask;
                // Clear each bit just before its line is served. If all bits were cleared at once,
                // a thread that blocks on one line would hide the others from its relief.
                if word.fetch_and(!mask, Ordering::Acquire) & mask == 0 {
                    continue;
                }
                let rest = self.send_for(index * 64 + mask.trailing_zeros() as usize, busy);
                if rest.more || rest.elsewhere {
                    word.fetch_or(mask, Ordering::Relaxed);
                }
                more |= rest.more;
            }
        }
        more
    }

    /// Sends for the lines of one bit.
    fn send_for(&self, bit: usize, busy: &Busy) -> Rest {
        let count = self.lock().all.len();
        let mut rest = Rest::default();
        for number in (bit..count).step_by(BITS) {
            let Some(mut taken) = self.take(number, false) else {
                rest.elsewhere |= self.is_out(number);
                continue;
            };
            let _working = busy.begin();
            if let Some(line) = &mut taken.line {
                rest.more |= (0..TURN).all(|_| line.send());
            }
        }
        rest
    }

    fn is_out(&self, number: usize) -> bool {
        matches!(self.lock().all.get(number), Some(Slot::Out))
    }
}
