//! Finds out whether the process of another daemon on this machine still runs.

use std::fs;

use serde::{Deserialize, Serialize};

/// Identifies a process of this machine, distinct from all others that ever had its process id.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub(crate) struct Process {
    /// Boot id and PID namespace; the process id is valid only there.
    place: String,
    number: u32,
    /// Start time in clock ticks since boot.
    started: String,
}

impl Process {
    pub(crate) fn this() -> Self {
        let number = std::process::id();
        Self { place: place(), number, started: started(number).unwrap_or_default() }
    }

    /// Whether it is known to have ended; false for processes of another machine or namespace.
    pub(crate) fn has_ended(&self) -> bool {
        let here = place();
        !here.is_empty()
            && self.place == here
            && !self.started.is_empty()
            && started(self.number).as_ref() != Some(&self.started)
    }
}

fn place() -> String {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let namespace = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    format!("{} {}", boot.trim(), namespace.display())
}

/// Field 22 of `/proc/<pid>/stat`. The name in field 2 may contain blanks and parentheses.
fn started(number: u32) -> Option<String> {
    let stat = fs::read_to_string(format!("/proc/{number}/stat")).ok()?;
    let fields = stat.rsplit_once(')')?.1;
    // A zombie counts as ended: its sockets are closed.
    let mut fields = fields.split_whitespace();
    let state = fields.next()?;
    (state != "Z" && state != "X").then(|| fields.nth(18).map(str::to_owned))?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_runs_and_others_have_ended() {
        let this = Process::this();
        assert!(!this.has_ended());
        assert!(Process { started: "1".into(), ..this.clone() }.has_ended());
        assert!(Process { number: u32::MAX, ..this.clone() }.has_ended());
        assert!(!Process { place: "elsewhere".into(), number: u32::MAX, ..this }.has_ended());
    }
}
