//! Tells whether the process of another daemon on this machine still runs.

use std::fs;

use serde::{Deserialize, Serialize};

/// A process of this machine, told apart from all that ever had its number.
#[derive(Clone, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub(crate) struct Process {
    /// Boot of the machine and PID namespace: the number means something there only.
    place: String,
    number: u32,
    /// When it started, in ticks since the boot.
    started: String,
}

impl Process {
    pub(crate) fn this() -> Self {
        let number = std::process::id();
        Self { place: place(), number, started: started(number).unwrap_or_default() }
    }

    /// Whether it is known to have ended. Of processes elsewhere nothing is known.
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

/// Field 22 of the process's state; the name before it may hold blanks and parentheses.
fn started(number: u32) -> Option<String> {
    let stat = fs::read_to_string(format!("/proc/{number}/stat")).ok()?;
    let fields = stat.rsplit_once(')')?.1;
    // A zombie holds no sockets any more.
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
