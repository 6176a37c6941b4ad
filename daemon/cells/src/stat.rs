//! What `/proc/PID/stat` says of a process (proc_pid_stat(5)).

use std::fs;

use rustix::process::Pid;

/// The text, of one moment.
pub(crate) struct Stat(String);

impl Stat {
    /// `None` when there is no such process.
    pub(crate) fn of(pid: Pid) -> Option<Self> {
        fs::read_to_string(format!("/proc/{pid}/stat")).ok().map(Self)
    }

    /// The field of this number, from 3, the state.
    pub(crate) fn field(&self, number: usize) -> Option<&str> {
        // The name before it, in brackets, may contain anything.
        self.0.rsplit(") ").next()?.split_ascii_whitespace().nth(number - 3)
    }
}
