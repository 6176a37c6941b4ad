//! A state of the system: where a component is between two steps.
//!
//! Activities have no identity of their own: lists are in the order that the rules use (of
//! acceptance, of admission), and what is equal for the rules is equal here.
//!
//! A search copies a state for each step, so copies are made into the memory of an earlier one:
//! `clone_from` keeps the lists that are there.

use crate::action::End;
use genom_timing::Lock;

/// A state of the system.
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct State {
    /// Phase of the component's life.
    pub phase: Phase,
    /// The tasks, in the model's order.
    pub tasks: Vec<Task>,
    /// Activities that were accepted and not sent to their tasks, in order of acceptance.
    pub pending: Vec<Pending>,
    /// Requests being served, in the order of services.
    pub workers: Vec<Worker>,
    /// Who executes what, and who waits for that.
    pub lock: Lock,
    /// Services that were executed, as far as a `before` or `after` names them.
    pub ran: Vec<u16>,
    /// A permanent activity ended with an exception.
    pub failed: bool,
    /// Number of the next activity; 0 if activities are not numbered.
    pub next: u32,
}

/// Phases of a component's life (genom3.md 7.2, 7.7).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Phase {
    /// Tasks before this one have begun.
    Starting(u16),
    /// Requests are served.
    #[default]
    Running,
    /// It shuts down.
    Stopping(Step),
    /// Nothing runs any more.
    Stopped,
}

/// Steps of a shutdown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Step {
    /// Waits for activities of services, and requests being served.
    #[default]
    Activities,
    /// Waits for the permanent activity of this task.
    Permanent(u16),
}

/// A task.
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct Task {
    /// Where it is.
    pub at: At,
    /// Its activities in order of admission.
    pub runs: Vec<Run>,
    /// Sent to it, and not admitted.
    pub inbox: Vec<Run>,
    /// Ended, and not collected by control.
    pub outbox: Vec<Run>,
    /// External events that it has not taken, by index.
    pub fired: Vec<u16>,
    /// Something happened that an aperiodic task looks at.
    pub runnable: bool,
    /// A codel of this pass yielded a state without pause.
    pub again: bool,
    /// Something moved in this pass.
    pub moved: bool,
    /// A tick came while it was at work.
    pub late: bool,
    /// 2 in its first pass, 1 in the rest of its first cycle.
    pub young: u8,
}

/// Where a task is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum At {
    /// Not started.
    #[default]
    Absent,
    /// Waits for a tick, or for something to happen.
    Sleep,
    /// A pass is due: that of a tick, or one that continues a cycle.
    Begin {
        /// Whether it is the pass of a tick.
        tick: bool,
    },
    /// Executes the codel of a place of a run, or waits for that.
    Codel {
        /// Place in the list of runs.
        run: u16,
        /// Place in the run's list.
        place: u16,
    },
    /// Reads the outputs of a run that ended, or waits for that.
    Fetch {
        /// Place in the list of runs.
        run: u16,
    },
    /// Wakes the other tasks at the end of a pass.
    Wake,
}

/// A run of a state machine.
#[derive(Debug, PartialEq, Eq, Hash)]
pub struct Run {
    /// Its machine, by index in the plan.
    pub machine: u16,
    /// Phase of its life.
    pub life: Life,
    /// Begins in `stop`: a permanent activity made again for a shutdown.
    pub at_stop: bool,
    /// Was asked to stop while it ran.
    pub asked: bool,
    /// Its active states.
    pub places: Vec<Place>,
    /// How it ended, once it has.
    pub end: Option<End>,
    /// Its number; 0 if activities are not numbered.
    pub number: u32,
}

/// Phases of a run's life (genom3.md 7.4).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Life {
    /// Not begun.
    #[default]
    Init,
    /// Begun.
    Run,
    /// In its `stop` state or a later one.
    Stop,
    /// Stopped before it began.
    Cancelled,
}

/// An active state of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Place {
    /// The state, by index in the model.
    pub state: u16,
    /// Whether its codel runs in the next pass.
    pub mode: Mode,
}

/// Whether a place takes part in the next pass. In order: of two that meet, the greater one stays.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Mode {
    /// It has ended, in this pass.
    #[default]
    Done,
    /// Waits for an external event, or a stop.
    Asleep,
    /// Waits for a tick, or for something to happen.
    Paused,
    /// Its codel runs next.
    Ready,
}

/// An activity that was accepted and waits for those it interrupts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Pending {
    /// Its service.
    pub service: u16,
    /// Its number; 0 if activities are not numbered.
    pub number: u32,
}

/// A request being served.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Worker {
    /// The service.
    pub service: u16,
    /// What comes next.
    pub pc: Pc,
}

/// What comes next for a request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pc {
    /// This item of the service's work: it is executed, or waited for.
    Work(u16),
    /// Wakes the tasks; the request succeeded or not.
    Wake(bool),
    /// Interrupts, accepts, answers.
    #[default]
    Conclude,
}

/// Copies field by field, into lists that are there.
macro_rules! copied {
    ($type:ident { $($field:ident),* }) => {
        impl Clone for $type {
            fn clone(&self) -> Self {
                Self { $($field: self.$field.clone()),* }
            }

            fn clone_from(&mut self, source: &Self) {
                $(self.$field.clone_from(&source.$field);)*
            }
        }
    };
}

copied! { State { phase, tasks, pending, workers, lock, ran, failed, next } }
copied! { Task { at, runs, inbox, outbox, fired, runnable, again, moved, late, young } }
copied! { Run { machine, life, at_stop, asked, places, end, number } }
