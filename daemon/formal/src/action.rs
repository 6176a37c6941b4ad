//! Steps of the system, and what clients are told by them.

/// A step. Indices are those of the model: tasks, services and states in its order. A context is a
/// task, by index, or the worker that serves a service: the number of tasks plus its index.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Action {
    /// The next task of the start-up gets its permanent activity, and begins (R1).
    Start,
    /// The start-up or the shutdown takes its next step (R1, R15).
    Advance,
    /// The tick of a task (R2).
    Tick(u16),
    /// A shutdown wakes a periodic task before its next tick (R15).
    Hurry(u16),
    /// A task begins a pass (R3).
    Begin(u16),
    /// A task that moved or ended something wakes the others (R8).
    Wake(u16),
    /// The codel or data transfer that a context executes ends, with this result (R6).
    Return(u16, Answer),
    /// Control collects the ended activities of a task, or of all tasks (R9).
    Collect(Option<u16>),
    /// A client requests a service (R10).
    Request(u16),
    /// The worker of a service goes on without executing anything (R11).
    Proceed(u16),
    /// `abort_activity`, served by the worker of that service, stops an activity (R13).
    Abort(u16, Target),
    /// An external event reaches a task (R14); the second index is that of the event.
    Fire(u16, u16),
    /// The component is asked to end (R15).
    Kill,
}

/// What a codel returned, as far as the rules distinguish it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Answer {
    /// A state, which runs in the next pass.
    Go(u16),
    /// A state, after a pause.
    Pause(u16),
    /// `sleep`: the place waits for an external event or a stop, in the state named.
    Sleep(u16),
    /// `ether`.
    End,
    /// `ok` of a codel that control calls, or the end of a data transfer.
    Ok,
    /// An exception, or anything that the codel may not return.
    Fail,
}

/// The activity that an abort is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// None that there is.
    Nobody,
    /// One that waits to be sent to its task, by place in the list.
    Pending(u16),
    /// One that was sent to this task and has not begun, by place in its inbox.
    Sent(u16, u16),
    /// One that this task has, by place in its list.
    Runs(u16, u16),
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum End {
    /// All its places have ended.
    Success,
    /// Asked to stop, before it began or without a `stop` codel.
    Interrupted,
    /// With an exception.
    Failed,
}

/// What a client is told by a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Told {
    /// The activity with this number was accepted.
    Accepted(u32),
    /// The activity with this number ended.
    Ended(u32, End),
    /// A request of this service ended: an attribute or function, or one that was refused.
    Answered(u16, End),
}
