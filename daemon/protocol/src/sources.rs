//! What a running component was made of: enough to read its description again elsewhere, and to know
//! how its tasks are executed.

use serde::{Deserialize, Serialize};

use crate::{ClockKind, ExecutionKind};

/// What a component was made of.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Sources {
    /// Instance name.
    pub name: String,
    /// Name of the component in its description.
    pub component: String,
    /// Digest of its interface: who reads the texts and gets another one has another version of
    /// genomd.
    pub digest: String,
    /// The description, by path; if it is embedded in the library, its name.
    pub description: String,
    /// The texts that were read, the description and what it includes, as they were then.
    pub texts: Vec<SourceText>,
    /// Directories in which included files were searched.
    pub include: Vec<String>,
    /// Its tasks as they are executed, in order of declaration.
    pub tasks: Vec<TaskSettings>,
    /// Activities of services that one task may have at the same time.
    pub max_activities: usize,
    /// Which threads execute it.
    pub execution: ExecutionKind,
    /// Its clock.
    pub clock: ClockKind,
}

/// A text that was read for a description.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct SourceText {
    /// The path by which it was read.
    pub path: String,
    /// Its content; a file that is not UTF-8 is read as Latin-1.
    pub text: String,
}

/// How a task is executed: as its description says, except for what the configuration overrides.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TaskSettings {
    /// Name of the task.
    pub name: String,
    /// Its period, in nanoseconds; absent if it is aperiodic.
    pub period_ns: Option<u64>,
    /// From 0, the highest, to 255, the lowest.
    pub priority: u32,
    /// Whether a real-time priority was requested; the statistics say whether it was granted.
    pub real_time: bool,
    /// Processors that it may run on; empty for any.
    pub cpus: Vec<usize>,
}

impl Sources {
    /// Texts longer than this together are not sent, in bytes.
    pub const LARGEST: usize = 16 << 20;
}
