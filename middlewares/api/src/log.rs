//! What components log, for middlewares whose tools show such entries.

use serde::{Deserialize, Serialize};

/// An entry of a component's log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogEntry {
    /// The component instance.
    pub instance: String,
    /// When it was logged, in nanoseconds since 1970.
    pub time: i64,
    /// Its severity.
    pub level: LogLevel,
    /// What logged it: a module of the daemon.
    pub place: String,
    /// The source file there; empty where it is not known.
    pub file: String,
    /// The line in it, from 1; 0 where it is not known.
    pub line: u32,
    /// The message.
    pub message: String,
}

/// Severity of an entry, from the least.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum LogLevel {
    /// Details for those who look for a fault.
    Debug,
    /// What happens in the normal course.
    Info,
    /// What may become a fault.
    Warn,
    /// What failed.
    Error,
}
