//! Options of an instance.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use crate::api::Supervision;
use crate::clock::Clock;
use crate::executor::Executor;
use crate::frozen::Resume;
use crate::rules::Supervised;
use crate::watcher::Watcher;

/// Default limit on the activities of services that one task runs at the same time (genom3.md D).
pub const ACTIVITY_LIMIT: usize = 16;

/// Asked while waiting: true to stop waiting.
pub type GiveUp = Arc<dyn Fn() -> bool + Send + Sync>;

/// Which threads execute the tasks and the control work of an instance.
///
/// On a [virtual clock](Clock::Virtual) this makes no difference: the thread that steps the clock
/// executes everything, so that a component makes the same sequence of codel calls.
#[derive(Clone, Debug, Default)]
pub enum Execution {
    /// A thread for each task, one for control, and further ones for requests.
    #[default]
    Threads,
    /// One thread, which the instance shares with all others of this executor. What is due is done
    /// one after the other in the order of deadlines: passes of tasks, and requests between them.
    Single(Arc<Executor>),
}

/// Options of an instance. Not `Clone`, since they belong to one instance.
pub struct Options {
    /// Instance name, which prefixes its ports, services and threads.
    pub name: String,
    /// The supervisor, which implements the standard services.
    pub supervision: Arc<dyn Supervision>,
    /// Real time, or a clock that is stepped.
    pub clock: Clock,
    /// Which threads execute it.
    pub execution: Execution,
    /// Limit on the activities of services that one task runs at the same time; the permanent one
    /// is not counted.
    pub activity_limit: usize,
    /// Overrides of the `.gen` for tasks, by task name.
    pub tasks: HashMap<String, TaskOptions>,
    /// Receives changes inside the instance.
    pub watcher: Option<Arc<dyn Watcher>>,
    /// Build date of the component, as published in `genom_state` (genom3.md 4.8); at most 30
    /// bytes.
    pub date: String,
    /// Timeout for the first codel of a task; `None` for no limit, as in genom3.md 7.2.
    pub start_timeout: Option<Duration>,
    /// Called several times a second while a first codel runs: true ends the wait, as the timeout
    /// does.
    pub give_up: Option<GiveUp>,
    /// A codel that runs longer counts as stuck; one of a periodic task after five periods, but not
    /// before one second (or this time, if shorter). Also the longest time for which control waits
    /// for codels.
    pub stuck_after: Duration,
    /// What it is supervised by, at most [`MOST_RULES`](crate::MOST_RULES); further ones are ignored.
    pub rules: Vec<Supervised>,
    /// Where another instance of the component was, to go on from there.
    pub resume: Option<Resume>,
    /// The [epoch](crate::Instance::epoch) of an instance whose ticks this one continues.
    pub epoch: Option<u64>,
}

/// Default of [`Options::stuck_after`].
pub const STUCK_AFTER: Duration = Duration::from_secs(5);

/// Overrides for a task; `None` keeps what the `.gen` says.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TaskOptions {
    /// Another period; ignored for an aperiodic task.
    pub period: Option<Duration>,
    /// Priority, from 0, the highest, to 255.
    pub priority: Option<u32>,
    /// Whether to request real-time scheduling.
    pub real_time: Option<bool>,
    /// Processors that the thread may run on; empty for any.
    pub cpus: Vec<usize>,
}

impl Options {
    /// Options with real time, default limits and no overrides.
    #[must_use]
    pub fn new(name: impl Into<String>, supervision: Arc<dyn Supervision>) -> Self {
        Self {
            name: name.into(),
            supervision,
            clock: Clock::Monotonic,
            execution: Execution::Threads,
            activity_limit: ACTIVITY_LIMIT,
            tasks: HashMap::new(),
            watcher: None,
            date: String::new(),
            start_timeout: None,
            give_up: None,
            stuck_after: STUCK_AFTER,
            rules: Vec::new(),
            resume: None,
            epoch: None,
        }
    }
}

impl fmt::Debug for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("name", &self.name)
            .field("clock", &self.clock)
            .field("execution", &self.execution)
            .field("activity_limit", &self.activity_limit)
            .field("tasks", &self.tasks)
            .finish_non_exhaustive()
    }
}
