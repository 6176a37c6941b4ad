//! Run-time exclusion of codels and data transfers (genom3.md 4.5, 7.10).
//!
//! Each context (a task, a control worker) runs at most one node at a time, and never waits for a
//! second one while it runs the first: deadlock is impossible. Without contention, entering and
//! leaving take one atomic operation each. Under contention, conflicting nodes enter in order of
//! arrival; nodes that conflict with none that runs or waits enter at once.
//!
//! If a component has more nodes than a word has bits, each context announces the node it runs in a
//! variable of its own, and checks those of the others.
//!
//! The module does not know codels or threads; [`Inheritance`] lends priorities.

mod guard;
mod inherit;
mod mask;
mod node;

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rustix::thread::futex;
use rustix::time::Timespec;

use crate::plan::Nodes;
use mask::{ALL, Masks, STILL, WAITERS};
use node::{EVERYTHING, IDLE, STANDSTILL, is_of_all};

pub(crate) use guard::PiLock;
pub use inherit::Inheritance;
pub(crate) use inherit::set_fifo;

/// The nodes that run, and those that wait.
#[derive(Debug)]
pub struct Exclusion {
    masks: Masks,
    /// Bits of running nodes, if one word is enough, and [`ALL`], [`STILL`] and [`WAITERS`].
    running: AtomicU64,
    /// The node that each context runs or tries to run, if one word is not enough.
    announced: Option<Box<[AtomicU32]>>,
    /// Serialises the slow path, with priority inheritance.
    guard: PiLock,
    /// The node that each context waits for. Changed under `guard` only.
    waiting: Box<[Waiting]>,
    /// Last ticket drawn, by which arrivals are ordered. Changed under `guard` only.
    tickets: AtomicU64,
    /// Futex that waiters sleep on: counts nodes that leave while somebody waits.
    departures: AtomicU32,
    inheritance: Inheritance,
}

#[derive(Debug)]
struct Waiting {
    node: AtomicU32,
    ticket: AtomicU64,
}

/// Permission to run one node, returned on drop.
#[must_use]
#[derive(Debug)]
pub struct Permit<'a> {
    exclusion: &'a Exclusion,
    context: usize,
    /// Bit to clear on drop; 0 if the node was announced.
    bit: u64,
    waited: bool,
}

impl Permit<'_> {
    /// Whether it had to wait for a conflicting node.
    #[must_use]
    pub fn waited(&self) -> bool {
        self.waited
    }
}

impl Drop for Permit<'_> {
    #[inline]
    fn drop(&mut self) {
        self.exclusion.leave(self.context, self.bit);
    }
}

impl Exclusion {
    /// An exclusion of these nodes, run by `contexts` contexts.
    #[must_use]
    pub fn new(nodes: &Nodes, contexts: usize) -> Self {
        let masks = Masks::new(nodes, contexts);
        let idle = || Waiting { node: AtomicU32::new(IDLE), ticket: AtomicU64::new(0) };
        Self {
            running: AtomicU64::new(0),
            announced: (masks.words() > 1)
                .then(|| (0..contexts).map(|_| AtomicU32::new(IDLE)).collect()),
            masks,
            guard: PiLock::default(),
            waiting: (0..contexts).map(|_| idle()).collect(),
            tickets: AtomicU64::new(0),
            departures: AtomicU32::new(0),
            inheritance: Inheritance::new(contexts),
        }
    }

    /// Priorities of the threads of the contexts.
    #[must_use]
    pub fn inheritance(&self) -> &Inheritance {
        &self.inheritance
    }

    /// Waits until no conflicting node runs, and enters `node` in `context`.
    ///
    /// A context enters one node at a time, and one node is not entered by two contexts at once.
    #[inline]
    pub fn enter(&self, context: usize, node: usize) -> Permit<'_> {
        let node = u32::try_from(node).unwrap_or(EVERYTHING);
        self.inheritance.runs(context, node);
        if let Some(bit) = self.try_enter(context, node) {
            return Permit { exclusion: self, context, bit, waited: false };
        }
        // Without a timeout it always enters.
        let waited = self.enter_slowly(context, node, None).unwrap_or(true);
        Permit { exclusion: self, context, bit: self.bit(context, node), waited }
    }

    /// Waits until none of the codels runs that have to be excluded, and keeps new ones out; gives
    /// up after `patience`, or never with `None`. While it waits, later arrivals queue behind it.
    ///
    /// This is the "global lock" of genom3.md 7.8. Async codels without port or remote are not
    /// excluded.
    pub fn enter_all(&self, context: usize, patience: Option<Duration>) -> Option<Permit<'_>> {
        self.enter_outside(context, EVERYTHING, patience)
    }

    /// The same for all nodes, async ones too: no codel at all runs while the permit is held.
    pub fn stand_still(&self, context: usize, patience: Option<Duration>) -> Option<Permit<'_>> {
        self.enter_outside(context, STANDSTILL, patience)
    }

    fn enter_outside(
        &self,
        context: usize,
        all: u32,
        patience: Option<Duration>,
    ) -> Option<Permit<'_>> {
        self.inheritance.runs(context, all);
        match self.enter_slowly(context, all, patience) {
            Some(waited) => {
                let bit = self.bit(context, all);
                Some(Permit { exclusion: self, context, bit, waited })
            }
            None => {
                self.inheritance.runs(context, IDLE);
                None
            }
        }
    }

    /// Whether excluding everything waits for this node.
    #[must_use]
    pub fn is_excluded(&self, node: usize) -> bool {
        u32::try_from(node).is_ok_and(|node| self.masks.is_global(node))
    }

    /// Whether a context waits to enter a node.
    #[must_use]
    pub fn is_waiting(&self, context: usize) -> bool {
        self.waiting.get(context).is_some_and(|w| w.node.load(Ordering::Relaxed) != IDLE)
    }

    /// Contexts that wait, and may not enter as things are.
    #[must_use]
    pub fn blocked(&self) -> Vec<usize> {
        let mut blocked = Vec::with_capacity(self.waiting.len());
        self.guard.lock();
        for (context, place) in self.waiting.iter().enumerate() {
            let node = place.node.load(Ordering::Relaxed);
            let ticket = place.ticket.load(Ordering::Relaxed);
            if node != IDLE && !self.may_enter(context, node, ticket) {
                blocked.push(context);
            }
        }
        self.guard.unlock();
        blocked
    }

    /// Enters a node without waiting; returns the bit that was set, or `None` if a conflicting node
    /// runs.
    #[inline]
    fn try_enter(&self, context: usize, node: u32) -> Option<u64> {
        if let Some(announced) = &self.announced {
            return self.announce(announced, context, node).then_some(0);
        }
        let (need, bit) = self.masks.fast(context, node)?;
        let word = &self.running;
        let mut seen = word.load(Ordering::Relaxed);
        while seen & need == 0 {
            let set = seen | bit;
            match word.compare_exchange_weak(seen, set, Ordering::AcqRel, Ordering::Relaxed) {
                Ok(_) => return Some(bit),
                Err(now) => seen = now,
            }
        }
        None
    }

    /// Announces the node, then checks the other contexts: if two announce at the same time, at
    /// least one sees the other. Withdraws the announcement when there is a conflict.
    #[inline]
    fn announce(&self, announced: &[AtomicU32], context: usize, node: u32) -> bool {
        announced[context].store(node, Ordering::SeqCst);
        let closed = self.running.load(Ordering::SeqCst) & (self.flags(node) | WAITERS) != 0;
        if !closed && self.none_announced(announced, context, node) {
            return true;
        }
        announced[context].store(IDLE, Ordering::SeqCst);
        // A waiter may have seen the announcement and gone to sleep.
        if self.running.load(Ordering::SeqCst) & WAITERS != 0 {
            self.ring(context);
        }
        false
    }

    /// The flags that keep a node out.
    fn flags(&self, node: u32) -> u64 {
        if self.masks.is_global(node) { ALL | STILL } else { STILL }
    }

    /// Whether no other context has announced a node that conflicts with `node`.
    fn none_announced(&self, announced: &[AtomicU32], context: usize, node: u32) -> bool {
        announced.iter().enumerate().all(|(other, slot)| {
            let its = slot.load(Ordering::SeqCst);
            its == IDLE || other == context || !self.masks.conflict(node, its)
        })
    }

    /// Enters by the slow path; returns whether it had to wait, `None` when it gave up.
    #[cold]
    fn enter_slowly(&self, context: usize, node: u32, patience: Option<Duration>) -> Option<bool> {
        let end = patience.map(|patience| Instant::now() + patience);
        self.guard.lock();
        let ticket = self.tickets.load(Ordering::Relaxed) + 1;
        self.tickets.store(ticket, Ordering::Relaxed);
        let place = &self.waiting[context];
        place.ticket.store(ticket, Ordering::Relaxed);
        place.node.store(node, Ordering::Relaxed);
        // From here on all contexts take the slow path, and each one that leaves wakes the waiters.
        self.running.fetch_or(WAITERS, Ordering::SeqCst);
        let mut waited = false;
        loop {
            // Read before the check: if a node leaves after the check, the futex does not sleep.
            let departures = self.departures.load(Ordering::Acquire);
            if self.may_enter(context, node, ticket) {
                break;
            }
            waited = true;
            let left = end.map(|end| end.saturating_duration_since(Instant::now()));
            if left.is_some_and(|left| left.is_zero()) {
                self.give_up(context);
                return None;
            }
            self.inheritance.lend(context, |other, its| self.holds_up(context, other, its));
            self.guard.unlock();
            // After a spurious return the loop checks again.
            let left = left.and_then(|left| Timespec::try_from(left).ok());
            let flags = futex::Flags::PRIVATE;
            let _ = futex::wait(&self.departures, flags, departures, left.as_ref());
            self.guard.lock();
        }
        match &self.announced {
            Some(announced) if !is_of_all(node) => {
                announced[context].store(node, Ordering::SeqCst);
            }
            _ => {
                self.running.fetch_or(self.bit(context, node), Ordering::SeqCst);
            }
        }
        self.waits_no_more(context);
        self.guard.unlock();
        Some(waited)
    }

    /// Removes `context` from the waiters. Called under `guard`.
    fn waits_no_more(&self, context: usize) {
        self.waiting[context].node.store(IDLE, Ordering::Relaxed);
        if self.waiting.iter().all(|other| other.node.load(Ordering::Relaxed) == IDLE) {
            self.running.fetch_and(!WAITERS, Ordering::SeqCst);
        }
    }

    /// Leaves the queue and wakes those behind. Called under `guard`, which it releases.
    fn give_up(&self, context: usize) {
        self.waits_no_more(context);
        self.guard.unlock();
        self.departures.fetch_add(1, Ordering::Release);
        let _ = futex::wake(&self.departures, futex::Flags::PRIVATE, i32::MAX as u32);
    }

    /// Whether no running node, and no earlier waiter, conflicts. Called under `guard`.
    fn may_enter(&self, context: usize, node: u32, ticket: u64) -> bool {
        let running = self.running.load(Ordering::SeqCst);
        let free = match &self.announced {
            Some(announced) => {
                running & self.flags(node) == 0 && self.none_announced(announced, context, node)
            }
            None => running & self.masks.need(node) == 0,
        };
        free && self.waiting.iter().enumerate().all(|(other, place)| {
            let its = place.node.load(Ordering::Relaxed);
            other == context
                || its == IDLE
                || place.ticket.load(Ordering::Relaxed) > ticket
                || !self.masks.conflict(node, its)
        })
    }

    /// Whether `context` waits, directly or through earlier waiters, for context `other`, which
    /// runs node `its`. Called under `guard`.
    fn holds_up(&self, context: usize, other: usize, its: u32) -> bool {
        let mine = &self.waiting[context];
        let (node, ticket) =
            (mine.node.load(Ordering::Relaxed), mine.ticket.load(Ordering::Relaxed));
        let runs = self.is_set(other, its);
        let directly = self.masks.conflict(node, its);
        runs && (directly
            || self.waiting.iter().any(|place| {
                let theirs = place.node.load(Ordering::Relaxed);
                theirs != IDLE
                    && place.ticket.load(Ordering::Relaxed) < ticket
                    && self.masks.conflict(node, theirs)
                    && self.masks.conflict(theirs, its)
            }))
    }

    fn is_set(&self, context: usize, node: u32) -> bool {
        match &self.announced {
            Some(announced) if !is_of_all(node) => {
                announced[context].load(Ordering::SeqCst) == node
            }
            _ => self.running.load(Ordering::SeqCst) & self.bit(context, node) != 0,
        }
    }

    /// The bit of a running node; 0 if nodes are announced instead.
    fn bit(&self, context: usize, node: u32) -> u64 {
        match node {
            EVERYTHING => ALL,
            STANDSTILL => STILL,
            _ if self.announced.is_some() => 0,
            _ => self.masks.bit(context, node),
        }
    }

    #[inline]
    fn leave(&self, context: usize, bit: u64) {
        let before = match &self.announced {
            Some(announced) if bit == 0 => {
                announced[context].store(IDLE, Ordering::SeqCst);
                self.running.load(Ordering::SeqCst)
            }
            // The bit is set, so subtracting clears it; unlike `and`, that is a single instruction.
            _ => self.running.fetch_sub(bit, Ordering::SeqCst),
        };
        if before & WAITERS != 0 {
            self.ring(context);
        }
        self.inheritance.runs(context, IDLE);
    }

    #[cold]
    fn ring(&self, context: usize) {
        self.guard.lock();
        self.inheritance.give_back(context);
        self.guard.unlock();
        self.departures.fetch_add(1, Ordering::Release);
        let _ = futex::wake(&self.departures, futex::Flags::PRIVATE, i32::MAX as u32);
    }
}
