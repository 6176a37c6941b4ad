//! One run of a service or permanent activity, which control and task pass to each other.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicUsize, Ordering};

use genom_description::model::{Ix as _, StateIx};

use crate::body::{EventId, Frame};

/// Phases of an activity's life (genom3.md 7.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Status {
    /// Validated, not started.
    Init,
    Run,
    /// In its `stop` state or a later one.
    Stop,
    /// Ended; control has not collected the result yet.
    Ether,
    /// Stopped before it started: it will never start.
    Cancelled,
}

impl Status {
    fn of(number: u8) -> Self {
        match number {
            0 => Status::Init,
            1 => Status::Run,
            2 => Status::Stop,
            3 => Status::Ether,
            _ => Status::Cancelled,
        }
    }
}

/// Flag for pause or sleep, beside the state in [`Marker::place`].
const PAUSED: usize = 1 << (usize::BITS - 1);

/// State of an activity that control and task share while the task has the run.
#[derive(Debug)]
pub(crate) struct Marker {
    status: AtomicU8,
    /// Written by control, checked in every pass.
    stop: AtomicBool,
    /// State of the first token, for readers outside the task.
    place: AtomicUsize,
}

impl Marker {
    pub(crate) fn new(state: StateIx) -> Self {
        Self {
            status: AtomicU8::new(Status::Init as u8),
            stop: AtomicBool::new(false),
            place: AtomicUsize::new(state.index()),
        }
    }

    pub(crate) fn status(&self) -> Status {
        Status::of(self.status.load(Ordering::Acquire))
    }

    pub(crate) fn set(&self, status: Status) {
        self.status.store(status as u8, Ordering::Release);
    }

    /// Changes from `Init` to `to`; `false` when control or task has left `Init` before.
    pub(crate) fn leave_init(&self, to: Status) -> bool {
        let (from, to) = (Status::Init as u8, to as u8);
        self.status.compare_exchange(from, to, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }

    pub(crate) fn request_stop(&self) {
        self.stop.store(true, Ordering::Release);
    }

    pub(crate) fn stop_requested(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    /// Publishes the state of the activity; returns whether it changed.
    pub(crate) fn show(&self, token: Token) -> bool {
        let paused = if token.mode == Mode::Ready { 0 } else { PAUSED };
        let place = token.state.index() | paused;
        let changed = self.place.load(Ordering::Relaxed) != place;
        self.place.store(place, Ordering::Relaxed);
        changed
    }

    /// State, and whether it is paused or asleep.
    pub(crate) fn place(&self) -> (StateIx, bool) {
        let place = self.place.load(Ordering::Relaxed);
        (StateIx::new(place & !PAUSED), place & PAUSED != 0)
    }
}

/// A token of the marking: an active state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) state: StateIx,
    pub(crate) mode: Mode,
}

/// Whether a token takes part in the next pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Mode {
    /// It has reached `ether`.
    Done,
    /// Waits for an external event or `stop`.
    Asleep,
    /// Waits for the next tick, or an event in the component.
    Paused,
    Ready,
}

/// An [`Outcome`](crate::Outcome) in numbers only, since the task must not allocate. Control
/// converts it when the run comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RunOutcome {
    Success,
    /// A declared exception.
    Thrown(EventId),
    /// A codel returned an event that it may not return.
    Bad {
        from: StateIx,
        to: Bad,
    },
    /// The codel did not return.
    Failed,
    /// Asked to stop, without a `stop` codel.
    Interrupted,
    /// Asked to stop before it started.
    Cancelled,
}

/// An event that the codel may not return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bad {
    Ok,
    Event(EventId),
    /// A string that is not an event of the plan; the frame keeps it.
    Unknown,
}

/// A run: created by control, sent to its task, and sent back at its end.
pub(crate) struct Run {
    pub(crate) id: u32,
    /// Its state machine, by index in the plan.
    pub(crate) machine: usize,
    pub(crate) frame: Box<dyn Frame>,
    pub(crate) marker: Arc<Marker>,
    /// The marking, as a set. Control allocates its capacity, so that the task never allocates.
    pub(crate) tokens: Vec<Token>,
    /// Begins in `stop`, as a permanent activity created again at shutdown (genom3.md 7.7), or has
    /// been there.
    pub(crate) at_stop: bool,
    /// Its outcome, once it has ended.
    pub(crate) outcome: Option<RunOutcome>,
}

impl std::fmt::Debug for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Run({} {:?} {:?})", self.id, self.tokens, self.outcome)
    }
}
