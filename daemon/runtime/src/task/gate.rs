//! What a task uses during its passes, and what others use of it between two of them.

use std::ops::{Deref, DerefMut};
use std::sync::{Mutex, MutexGuard};
use std::time::Instant;

use rtrb::{Consumer, Producer};

use super::core::Core;
use super::run::Run;
use crate::exclusion::PiLock;
use crate::lock::lock;
use crate::rules::{Formulas, Seen};
use crate::shared::Notice;

/// A task's ends of the rings to and from control, which are bounded and wait-free.
pub(crate) struct TaskSide {
    /// Runs to start.
    pub(crate) inbox: Consumer<Box<Run>>,
    /// Runs that ended.
    pub(crate) outbox: Producer<Box<Run>>,
    /// Notices to watchers; `None` if there are none.
    pub(crate) notices: Option<Producer<Notice>>,
    /// Rules that were broken; `None` if there are no rules.
    pub(crate) broken: Option<Producer<Seen>>,
}

/// The activities of a task, and its ends of the rings.
pub(crate) struct Inside {
    pub(crate) core: Core,
    pub(crate) side: TaskSide,
    /// Formulas that this task's thread alone moves on.
    pub(crate) own: Formulas,
    /// Date at which the last cycle began: the ticks until then are served, or missed.
    pub(crate) passed: u64,
}

impl Inside {
    /// Takes in the runs that control has sent.
    pub(crate) fn admit_sent(&mut self) {
        while let Ok(run) = self.side.inbox.pop() {
            self.core.admit(run);
        }
    }
}

/// Held by a task during each of its passes: whoever else holds it is between two of them.
///
/// Without contention it costs a few atomic operations. A task that waits lends its priority to the
/// holder, which only copies memory.
pub(crate) struct Gate {
    turn: PiLock,
    /// Locked only by who has the turn, so that nobody waits here.
    inside: Mutex<Inside>,
}

/// The gate, held until this is dropped. Fields are dropped in this order.
pub(crate) struct Held<'a> {
    inside: MutexGuard<'a, Inside>,
    _turn: Turn<'a>,
}

struct Turn<'a>(&'a PiLock);

impl Drop for Turn<'_> {
    fn drop(&mut self) {
        self.0.unlock();
    }
}

impl Gate {
    pub(crate) fn new(inside: Inside) -> Self {
        Self { turn: PiLock::default(), inside: Mutex::new(inside) }
    }

    /// Waits for the other holder.
    #[inline]
    pub(crate) fn lock(&self) -> Held<'_> {
        self.turn.lock();
        self.held()
    }

    /// `None` while the task makes a pass.
    pub(crate) fn try_lock(&self) -> Option<Held<'_>> {
        self.turn.try_lock().then(|| self.held())
    }

    /// Waits until the task has made its pass; `None` when that takes longer.
    pub(crate) fn lock_until(&self, end: Instant) -> Option<Held<'_>> {
        self.turn.lock_until(end).then(|| self.held())
    }

    #[inline]
    fn held(&self) -> Held<'_> {
        let _turn = Turn(&self.turn);
        Held { inside: lock(&self.inside), _turn }
    }
}

impl Deref for Held<'_> {
    type Target = Inside;

    fn deref(&self) -> &Inside {
        &self.inside
    }
}

impl DerefMut for Held<'_> {
    fn deref_mut(&mut self) -> &mut Inside {
        &mut self.inside
    }
}
