//! Formulas at run time.
//!
//! Where all that a formula hears of happens in the thread of one task, that thread has it, and
//! nobody else. Others are moved on by the threads of several tasks and requests, of which none
//! waits for another: whoever has the turn moves them on; whoever finds that another one has it
//! leaves what happened in a queue, and goes on; the one who has the turn takes that in before or
//! after its own. A thread that is interrupted in its turn delays verdicts, but no codel.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, TryLockError};

use crossbeam_queue::ArrayQueue;

use super::broken::{Fact, Seen};
use super::ear::Judges;
use genom_monitor::{Happening, Judge};

/// What waits for who has the turn, at most.
const MOST_WAITING: usize = 1024;

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

impl Happened {
    fn all(&self) -> (Happening, u32, u64) {
        (self.what, self.activity, self.date)
    }
}

/// Formulas that are moved on together.
#[derive(Debug, Default)]
pub(crate) struct Formulas {
    /// With the rule of each.
    judges: Box<[(usize, Judge)]>,
    /// The last date: none is before it.
    last: u64,
}

impl Formulas {
    pub(super) fn new(judges: Vec<(usize, Judge)>) -> Self {
        Self { judges: judges.into_boxed_slice(), last: 0 }
    }

    /// Those of `ears` hear something.
    #[inline]
    pub(super) fn hear(
        &mut self,
        (what, activity, date): (Happening, u32, u64),
        ears: &[Judges],
        mut tell: impl FnMut(Seen),
    ) {
        self.last = self.last.max(date);
        for Judges { at, letter } in ears {
            let Some((rule, judge)) = self.judges.get_mut(usize::from(*at)) else { continue };
            if let Some(part) = judge.hear_letter(letter, self.last) {
                let part = u8::try_from(part).unwrap_or(u8::MAX);
                tell(Seen { rule: *rule, activity, date, fact: Fact::False { what, part } });
            }
        }
    }
}

/// Formulas that several threads move on.
#[derive(Debug)]
pub(super) struct Shared {
    turn: Mutex<Formulas>,
    waiting: ArrayQueue<Happened>,
    /// What found no room there.
    pub(super) lost: AtomicU64,
}

impl Shared {
    pub(super) fn new(judges: Vec<(usize, Judge)>) -> Self {
        let room = if judges.is_empty() { 1 } else { MOST_WAITING };
        let turn = Mutex::new(Formulas::new(judges));
        Self { turn, waiting: ArrayQueue::new(room), lost: AtomicU64::new(0) }
    }

    /// Something happens. `ears` has those who hear what has a number. Tells what breaks rules, also
    /// by what others left.
    #[inline]
    pub(super) fn hear<'a>(
        &self,
        happened: Happened,
        ears: impl Fn(u32) -> &'a [Judges],
        mut tell: impl FnMut(Seen),
    ) {
        match self.turn() {
            Some(mut formulas) => {
                // What others left came before.
                self.empty_into(&mut formulas, &ears, &mut tell);
                formulas.hear(happened.all(), ears(happened.number), &mut tell);
            }
            None if self.waiting.push(happened).is_err() => {
                self.lost.fetch_add(1, Ordering::Relaxed);
            }
            None => {}
        }
        self.take_left(ears, tell);
    }

    /// Takes in what others left, unless somebody has the turn. What is left even so, the next one
    /// takes in, and control does that again and again.
    #[inline]
    pub(super) fn take_left<'a>(
        &self,
        ears: impl Fn(u32) -> &'a [Judges],
        mut tell: impl FnMut(Seen),
    ) {
        while !self.waiting.is_empty() {
            let Some(mut formulas) = self.turn() else { return };
            self.empty_into(&mut formulas, &ears, &mut tell);
        }
    }

    /// Takes in all that waits. To look whether anything does costs less than to take it.
    #[inline]
    fn empty_into<'a>(
        &self,
        formulas: &mut Formulas,
        ears: &impl Fn(u32) -> &'a [Judges],
        tell: &mut impl FnMut(Seen),
    ) {
        while !self.waiting.is_empty() {
            let Some(before) = self.waiting.pop() else { return };
            formulas.hear(before.all(), ears(before.number), &mut *tell);
        }
    }

    fn turn(&self) -> Option<MutexGuard<'_, Formulas>> {
        match self.turn.try_lock() {
            Ok(formulas) => Some(formulas),
            Err(TryLockError::Poisoned(poisoned)) => Some(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }
}
