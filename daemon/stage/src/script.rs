//! What is to happen, and when.

/// A run of one component.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Script {
    /// What happens, in order.
    pub steps: Vec<Step>,
}

/// Something that happens at a date.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Step {
    /// Nanoseconds from the start of the component; never less than those of the step before.
    pub at: u64,
    /// What happens.
    pub what: Move,
}

/// What happens, or is to be seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Move {
    /// This task makes a pass: that of a tick that has come, or one that continues.
    Pass(String),
    /// A codel that is being executed returns.
    Returns {
        /// The codel.
        codel: String,
        /// The task whose thread executes it; `None` for any, or for one that control executes.
        task: Option<String>,
        /// What it returns: a state, `pause::STATE`, `ether`, `ok`, or `exception`.
        yields: String,
    },
    /// A client requests this service, with the defaults of its inputs.
    Request(String),
    /// A client aborts the activity with this number.
    Abort(u32),
    /// This external event is fired.
    Fire(String),
    /// Control collects activities that ended.
    Control,
    /// A tick of this task comes at this very date, and finds it at work: the runtime counts it as
    /// missed.
    Late(String),
}
