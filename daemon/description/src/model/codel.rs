//! Codels: C functions, and the sources of their arguments.

use std::time::Duration;

use genom_types::TypeId;

use super::{Direction, PathStep, PortIx, RemoteIx, ServiceIx, Span, StateIx, TaskIx};

/// What a codel belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Owner {
    /// The permanent activity of a task, by index.
    Task(TaskIx),
    /// A service, by index.
    Service(ServiceIx),
}

/// One use of a C function: a function that is used twice makes two of these.
#[derive(Clone, Debug)]
pub struct Codel {
    /// Name of the C function.
    pub name: String,
    /// Task or service that it belongs to.
    pub owner: Owner,
    /// When it runs.
    pub kind: CodelKind,
    /// `async`: may block for long, and excludes no other codel (genom3.md K24).
    pub asynchronous: bool,
    /// Parameters in order; the context comes after them in C (genom3.md 5.6).
    pub parameters: Vec<CodelParameter>,
    /// `wcet`: declared worst-case execution time.
    pub wcet: Option<Duration>,
    /// Where it is declared.
    pub span: Span,
}

/// When a codel runs.
#[derive(Clone, Debug)]
pub enum CodelKind {
    /// Before the service is accepted.
    Validate,
    /// In the control task, in order.
    Simple,
    /// In a state of the state machine.
    Fsm {
        /// States that run it.
        triggers: Vec<StateIx>,
        /// What it may return.
        yields: Vec<Yield>,
    },
}

/// A state a codel may yield.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Yield {
    /// The state.
    pub state: StateIx,
    /// `pause::`: wait for the next tick or event first.
    pub pause: bool,
}

/// An argument of a codel.
#[derive(Clone, Debug)]
pub struct CodelParameter {
    /// Its name in the C prototype.
    pub name: String,
    /// Whether the codel reads, writes or changes the datum.
    pub direction: Direction,
    /// Type of the datum (for a port, of its data; for a remote, its input struct).
    pub ty: TypeId,
    /// Where the argument comes from.
    pub source: Source,
    /// Where it is declared.
    pub span: Span,
}

/// Where an argument comes from (genom3.md 4.4).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// The IDS; an empty path means the whole of it.
    Ids {
        /// From the IDS to the datum.
        path: Vec<PathStep>,
    },
    /// A parameter of the service, by index into `parameters`.
    Parameter {
        /// Index of the parameter.
        index: usize,
        /// From the parameter to the datum.
        path: Vec<PathStep>,
    },
    /// A local variable of the service, by index into `locals`.
    Local {
        /// Index of the local variable.
        index: usize,
        /// From the variable to the datum.
        path: Vec<PathStep>,
    },
    /// A port of the component, by index.
    Port(PortIx),
    /// A remote of the component, by index.
    Remote(RemoteIx),
}
