//! Rules by which tasks, codels and activities are supervised: alive, deadline and logical
//! supervision, in the words of AUTOSAR; heartbeats; and formulas.
//!
//! The thread that runs a codel compares its duration with one limit, and looks at two flags. Where
//! they are set it moves heartbeats, orders and formulas on, by index, without allocation and
//! without waiting for others; those that no other thread moves on, without atomic operations. What breaks a rule is counted and sent through a ring to control,
//! which tells it. A codel that has not returned, a heartbeat that does not come, and ticks that a
//! task misses meanwhile, are seen by whoever calls
//! [`Instance::supervise`](crate::Instance::supervise).

mod alive;
mod broken;
mod ear;
mod formulas;
mod hear;
mod look;
mod table;

use std::time::Duration;

use genom_description::model::{CodelIx, Owner, PortIx, ServiceIx, StateIx, TaskIx};

pub(crate) use broken::{Fact, Seen};
pub(crate) use formulas::Formulas;
pub use genom_monitor::{
    Asked, Bounds, Happening, Judge, MOST_PARTS, MOST_STEPS, NoOrder, NoProgram, Noted, Order,
    Part, Program,
};
pub(crate) use hear::Heard;
pub(crate) use table::{Bound, Rules};

/// Limit on the rules of an instance.
pub const MOST_RULES: usize = 32;

/// What must not happen. Indices are those of the component's model.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Alive: a periodic task misses so many ticks within this time.
    Missed {
        /// The task.
        task: TaskIx,
        /// How many, at least 1.
        ticks: u64,
        /// The length of a window that slides.
        within: Duration,
    },
    /// Deadline: a call of one of these codels takes longer than its limit.
    Longest {
        /// Codels with their limits.
        codels: Vec<(CodelIx, Duration)>,
    },
    /// Deadline: a call of one of these codels counts as stuck
    /// ([`Options::stuck_after`](crate::Options::stuck_after)).
    Stuck {
        /// The codels.
        codels: Vec<CodelIx>,
    },
    /// Deadline: an activity takes longer from its acceptance until its client is answered.
    Activity {
        /// Its service.
        service: ServiceIx,
        /// The limit.
        longest: Duration,
    },
    /// Logical: one of `codels` is called before one of `first` has returned, since the start of
    /// the instance.
    After {
        /// Codels that come later.
        codels: Vec<CodelIx>,
        /// Uses of the codel that comes first.
        first: Vec<CodelIx>,
    },
    /// Logical: one of these codels is called while an activity of this service runs.
    During {
        /// The codels.
        codels: Vec<CodelIx>,
        /// The service.
        service: ServiceIx,
    },
    /// Logical: a codel yields this step between states. Stop requests and external events are no
    /// steps of a codel.
    Step {
        /// The state machine: that of a task's permanent activity, or of a service.
        owner: Owner,
        /// The state whose codel ran.
        from: StateIx,
        /// The state that it yielded.
        to: StateIx,
    },
    /// Deadline: a cycle of a task takes longer.
    Cycle {
        /// The task.
        task: TaskIx,
        /// The limit.
        longest: Duration,
    },
    /// Deadline: an activity that was asked to stop takes longer to its end.
    Stop {
        /// Its service.
        service: ServiceIx,
        /// The limit.
        longest: Duration,
    },
    /// Heartbeat: it comes sooner after the one before, or does not come for longer.
    Beat {
        /// What beats.
        of: Beats,
        /// The least time between two.
        least: Duration,
        /// The longest time without one: from the start of the instance, or of the activity, on.
        longest: Duration,
        /// Only while activities of this service run.
        during: Option<ServiceIx>,
    },
    /// Logical: something happens that no step allows.
    Order(Order),
    /// It does not hold at something that it hears.
    Formula(Program),
}

/// What beats.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Beats {
    /// Calls of one of these codels.
    Codels(Vec<CodelIx>),
    /// Values that codels write on this port.
    Port(PortIx),
}

/// A rule, and what the instance itself does about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Supervised {
    /// The rule.
    pub rule: Rule,
    /// Whether the activity that breaks it is asked to stop, by `supervision`. For a task that
    /// misses ticks: all activities of services that it runs.
    pub interrupts: bool,
}

/// A rule was broken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Violation {
    /// Its index in [`Options::rules`](crate::Options::rules).
    pub rule: usize,
    /// What happened, as a sentence.
    pub what: String,
    /// The activity of a service that did it, if one did.
    pub activity: Option<u32>,
    /// How often the rule was broken so far.
    pub count: u64,
    /// When, by the clock of the instance.
    pub date: u64,
    /// Number of the thread whose codel has not returned; `None` if it did, or if unknown.
    pub thread: Option<u32>,
    /// What was measured, in nanoseconds, or the number of ticks missed.
    pub value: Option<u64>,
    /// What that was compared with.
    pub bound: Option<u64>,
}
