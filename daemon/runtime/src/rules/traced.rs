//! Orders and formulas at run time. Threads of all tasks and requests move them on; none of them
//! waits for another.
//!
//! Whoever has the turn moves them on. Whoever finds that another one has it leaves what happened in
//! a queue, and goes on; the one who has the turn takes that in before or after its own. A thread
//! that is interrupted in its turn delays verdicts, but no codel.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, TryLockError};

use crossbeam_queue::ArrayQueue;

use super::broken::{Fact, Seen};
use genom_monitor::Happening;
use genom_monitor::Judge;
use genom_monitor::Order;

/// What waits for who has the turn, at most.
const MOST_WAITING: usize = 1024;

/// Which monitor hears something, and under which number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hears {
    pub(super) monitor: u16,
    pub(super) letter: u16,
}

/// Something that happened.
#[derive(Clone, Copy, Debug)]
pub(super) struct Happened {
    pub(super) what: Happening,
    /// Its number in the table.
    pub(super) number: u32,
    /// The activity that did it; 0 if none did.
    pub(super) activity: u32,
    pub(super) date: u64,
}

/// An order or a formula.
#[derive(Debug)]
pub(super) enum Monitor {
    Order { order: Order, state: u8 },
    Formula(Judge),
}

#[derive(Debug)]
pub(super) struct Traced {
    turn: Mutex<Inside>,
    waiting: ArrayQueue<Happened>,
    /// What found no room there.
    pub(super) lost: AtomicU64,
}

#[derive(Debug)]
struct Inside {
    /// With the rule of each.
    monitors: Box<[(usize, Monitor)]>,
    /// The last date: none is before it.
    last: u64,
}

impl Traced {
    pub(super) fn new(monitors: Vec<(usize, Monitor)>) -> Self {
        let room = if monitors.is_empty() { 1 } else { MOST_WAITING };
        let inside = Inside { monitors: monitors.into_boxed_slice(), last: 0 };
        Self { turn: Mutex::new(inside), waiting: ArrayQueue::new(room), lost: AtomicU64::new(0) }
    }

    /// Something happens. `hearers` has those who hear what has a number. Tells what breaks rules,
    /// also by what others left.
    #[inline]
    pub(super) fn hear<'a>(
        &self,
        happened: Happened,
        hearers: impl Fn(u32) -> &'a [Hears],
        mut tell: impl FnMut(Seen),
    ) {
        match self.turn() {
            Some(mut inside) => {
                // What others left came before.
                self.empty_into(&mut inside, &hearers, &mut tell);
                inside.take(happened, hearers(happened.number), &mut tell);
            }
            None if self.waiting.push(happened).is_err() => {
                self.lost.fetch_add(1, Ordering::Relaxed);
            }
            None => {}
        }
        self.take_left(hearers, tell);
    }

    /// Takes in what others left, unless somebody has the turn. What is left even so, the next one
    /// takes in, and control does that again and again.
    #[inline]
    pub(super) fn take_left<'a>(
        &self,
        hearers: impl Fn(u32) -> &'a [Hears],
        mut tell: impl FnMut(Seen),
    ) {
        while !self.waiting.is_empty() {
            let Some(mut inside) = self.turn() else { return };
            self.empty_into(&mut inside, &hearers, &mut tell);
        }
    }

    /// Takes in all that waits. To look whether anything does costs less than to take it.
    #[inline]
    fn empty_into<'a>(
        &self,
        inside: &mut Inside,
        hearers: &impl Fn(u32) -> &'a [Hears],
        tell: &mut impl FnMut(Seen),
    ) {
        while !self.waiting.is_empty() {
            let Some(before) = self.waiting.pop() else { return };
            inside.take(before, hearers(before.number), tell);
        }
    }

    fn turn(&self) -> Option<MutexGuard<'_, Inside>> {
        match self.turn.try_lock() {
            Ok(inside) => Some(inside),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}

impl Inside {
    #[inline]
    fn take(&mut self, happened: Happened, hearers: &[Hears], tell: &mut impl FnMut(Seen)) {
        let Happened { what, activity, date, .. } = happened;
        self.last = self.last.max(date);
        for hears in hearers {
            let Some((rule, monitor)) = self.monitors.get_mut(usize::from(hears.monitor)) else {
                continue;
            };
            let letter = usize::from(hears.letter);
            let fact = match monitor {
                Monitor::Order { order, state } => match order.next(*state, letter) {
                    Some(next) => {
                        *state = next;
                        None
                    }
                    None => Some(Fact::Disordered { what, state: *state }),
                },
                Monitor::Formula(judge) => judge
                    .hear(letter, self.last)
                    .map(|part| Fact::False { what, part: u8::try_from(part).unwrap_or(u8::MAX) }),
            };
            if let Some(fact) = fact {
                tell(Seen { rule: *rule, activity, date, fact });
            }
        }
    }
}
