//! How an instance is to run.

use std::collections::HashMap;
use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use crate::api::Wiring;
use crate::clock::Clock;
use crate::watcher::Watcher;

/// Activities of services that one task runs at once, unless told otherwise (genom3.md D).
pub const ACTIVITY_LIMIT: usize = 16;

/// Whether to wait no longer for what is under way.
pub type GiveUp = Arc<dyn Fn() -> bool + Send + Sync>;

/// How an instance is to run. Not for cloning: it belongs to one instance.
pub struct Options {
    /// Instance name, which prefixes its ports, services and threads.
    pub name: String,
    /// The supervisor behind the standard services.
    pub wiring: Arc<dyn Wiring>,
    /// Real time, or a clock that is stepped.
    pub clock: Clock,
    /// Activities of services that one task runs at once; the permanent one is not counted.
    pub activity_limit: usize,
    /// Changes to what the `.gen` says of tasks, by task name.
    pub tasks: HashMap<String, TaskOptions>,
    /// Who wants to know what happens inside.
    pub watcher: Option<Arc<dyn Watcher>>,
    /// When the component was built, as `genom_state` tells it (genom3.md 4.8); at most 30 bytes.
    pub date: String,
    /// How long a task's first codel may take; `None` is no limit, as in genom3.md 7.2.
    pub start_timeout: Option<Duration>,
    /// Asked several times a second while a first codel runs: whether to wait for it no longer,
    /// as if its time were over.
    pub give_up: Option<GiveUp>,
    /// A codel that runs for longer counts as stuck; one of a periodic task does after a second,
    /// or five periods when these are longer. Also how long control waits for codels at most.
    pub stuck_after: Duration,
}

/// When a codel counts as stuck, unless told otherwise.
pub const STUCK_AFTER: Duration = Duration::from_secs(5);

/// What a configuration says of a task. What is `None` is as in the `.gen`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct TaskOptions {
    /// Another period; an aperiodic task cannot be given one.
    pub period: Option<Duration>,
    /// 0, the highest, to 255.
    pub priority: Option<u32>,
    /// Whether to ask for real-time scheduling.
    pub real_time: Option<bool>,
    /// Processors to run on; empty for any.
    pub cpus: Vec<usize>,
}

impl Options {
    /// Real time, default limits, nothing overridden.
    #[must_use]
    pub fn new(name: impl Into<String>, wiring: Arc<dyn Wiring>) -> Self {
        Self {
            name: name.into(),
            wiring,
            clock: Clock::Monotonic,
            activity_limit: ACTIVITY_LIMIT,
            tasks: HashMap::new(),
            watcher: None,
            date: String::new(),
            start_timeout: None,
            give_up: None,
            stuck_after: STUCK_AFTER,
        }
    }
}

impl fmt::Debug for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Options")
            .field("name", &self.name)
            .field("clock", &self.clock)
            .field("activity_limit", &self.activity_limit)
            .field("tasks", &self.tasks)
            .finish_non_exhaustive()
    }
}
