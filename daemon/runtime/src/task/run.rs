//! One run of a service or of a permanent activity, as it travels between control and task.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU32, Ordering};

use crate::body::{EventId, Frame};

/// Where an activity is in its life (genom3.md 7.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum Status {
    /// Validated, not started.
    Init,
    Run,
    /// In its `stop` state or beyond.
    Stop,
    /// Ended; the result waits for the control task.
    Ether,
    /// Stopped before it started: it never will.
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

/// Pause and sleep, beside the state in [`Marker::place`].
const PAUSED: u32 = 1 << 16;

/// What control and task share of an activity while the task has it.
#[derive(Debug)]
pub(crate) struct Marker {
    status: AtomicU8,
    /// Written by control, looked at on every pass.
    stop: AtomicBool,
    /// State of the first place of the marking, for readers outside the task.
    place: AtomicU32,
}

impl Marker {
    pub(crate) fn new(state: u16) -> Self {
        Self {
            status: AtomicU8::new(Status::Init as u8),
            stop: AtomicBool::new(false),
            place: AtomicU32::new(u32::from(state)),
        }
    }

    pub(crate) fn status(&self) -> Status {
        Status::of(self.status.load(Ordering::Acquire))
    }

    pub(crate) fn set(&self, status: Status) {
        self.status.store(status as u8, Ordering::Release);
    }

    /// From `Init` to `to`; `false` when control or task has left `Init` before.
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

    /// Shows where the activity is; whether that is somewhere else than before.
    pub(crate) fn show(&self, token: Token) -> bool {
        let paused = if token.mode == Mode::Ready { 0 } else { PAUSED };
        let place = u32::from(token.state) | paused;
        let changed = self.place.load(Ordering::Relaxed) != place;
        self.place.store(place, Ordering::Relaxed);
        changed
    }

    /// State, and whether it is paused or asleep.
    pub(crate) fn place(&self) -> (u16, bool) {
        let place = self.place.load(Ordering::Relaxed);
        ((place & 0xffff) as u16, place & PAUSED != 0)
    }
}

/// An active place of a marking.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Token {
    pub(crate) state: u16,
    pub(crate) mode: Mode,
}

/// Whether a place takes part in the next pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Mode {
    /// Reached `ether`.
    Done,
    /// Until an external event or `stop`.
    Asleep,
    /// Until the next tick or event in the component.
    Paused,
    Ready,
}

/// An [`Outcome`](crate::Outcome) as the task has it: numbers only, for the task allocates nothing.
/// Control makes the `Outcome` of it when the run comes back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RunOutcome {
    Success,
    /// With a declared exception.
    Thrown(EventId),
    /// With something the codel may not return.
    Bad {
        from: u16,
        to: Bad,
    },
    /// The codel did not return.
    Failed,
    /// Told to stop, without a codel for it.
    Interrupted,
    /// Told to stop before it started.
    Cancelled,
}

/// What a codel returned that it may not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Bad {
    Ok,
    Event(EventId),
    /// A string that is no event of the plan; the frame keeps it.
    Unknown,
}

/// A run: made by control, handed to its task, handed back at its end.
pub(crate) struct Run {
    pub(crate) id: u32,
    /// Its state machine, by rank in the plan.
    pub(crate) machine: usize,
    pub(crate) frame: Box<dyn Frame>,
    pub(crate) marker: Arc<Marker>,
    /// The marking, a set. Its room is made by control: the task never allocates.
    pub(crate) tokens: Vec<Token>,
    /// Starts in `stop`: a permanent activity made again for the shutdown (genom3.md 7.7).
    pub(crate) at_stop: bool,
    /// How it ended, once it has.
    pub(crate) outcome: Option<RunOutcome>,
}

impl std::fmt::Debug for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Run({} {:?} {:?})", self.id, self.tokens, self.outcome)
    }
}
