//! Executes the component model: tasks, activities, requests, exclusion (genom3.md 7).
//!
//! A [`Plan`] is a component compiled into arrays. An [`Instance`] runs a plan on a
//! [`Body`](body::Body), which is the component's code and memory: the runtime accesses both only
//! through the traits of [`body`]. It knows no middleware and does no I/O of its own.
//!
//! Each task has a thread, which shares with the others only atomics, wait-free rings and the
//! exclusion. Requests are served by control workers, in order for each service. With
//! [`Execution::Single`] one thread does all this for many instances. With a [`VirtualClock`] there
//! are no threads: the thread that steps the clock runs the tasks.

#![forbid(unsafe_code)]

mod api;
mod at_work;
pub mod body;
mod clock;
mod control;
mod cycles;
mod driven;
mod engine;
pub mod exclusion;
mod executor;
mod figures;
mod freeze;
mod frozen;
mod handover;
mod histogram;
mod instance;
mod lock;
mod member;
mod options;
pub mod plan;
mod rest;
mod resume;
mod rules;
mod running;
mod shared;
mod shutdown;
mod staged;
mod start;
mod statistics;
mod still;
mod stuck;
mod task;
mod ticket;
mod unpaused;
mod waits;
mod watcher;

/// Indices of the codels, ports, services, states and tasks of a component.
pub use genom_description::model::{CodelIx, Indexed, Ix, PortIx, ServiceIx, StateIx, TaskIx};

pub use api::{
    ActivityPhase, ConnectionError, Exception, Inputs, OnShutdown, Outcome, Partial, Progress,
    Reply, Supervision, input_record,
};
pub use clock::{Clock, OnStage, Stage, Turn, VirtualClock, nanos};
pub use engine::{ActivityStatus, NoSuchActivity};
pub use executor::Executor;
pub use freeze::FreezeError;
pub use frozen::{
    ChangeIds, Frozen, FrozenActivity, FrozenPort, FrozenToken, Resume, Resumed, Waiting,
};
pub use handover::HeirIds;
pub use histogram::Durations;
pub use instance::{Instance, NoSuchEvent};
pub use options::{ACTIVITY_LIMIT, Execution, GiveUp, Options, STUCK_AFTER, TaskOptions};
pub use plan::{Plan, PlanError};
pub use rest::{NoRest, Rest};
pub use rules::{
    Asked, Beats, Bounds, Happening, Judge, MOST_PARTS, MOST_RULES, MOST_STEPS, NoOrder, NoProgram,
    Noted, Order, Part, Program, Rule, Supervised, Violation,
};
pub use running::{HeldUp, RunningCodel, seconds};
pub use shutdown::ShutdownError;
pub use start::StartError;
pub use statistics::{CodelStatistics, Statistics, TaskHistograms, TaskStatistics};
pub use stuck::patience;
pub use ticket::Ticket;
pub use unpaused::Unpaused;
pub use waits::CannotWait;
pub use watcher::{Change, Watcher};
