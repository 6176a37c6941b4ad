//! Signals to processes that a test did not start itself, by their numbers.

use std::fmt::Display;
use std::fs;
use std::process::{Command, Stdio};

use crate::until;

/// Sends the signal `name` (`KILL`, `STOP`, …) to the process `pid`, and tells whether it was
/// there to receive it.
///
/// `kill` returns as soon as SIGSTOP is queued, when threads of the process may still run and
/// write files. After a `STOP` this therefore waits until every thread stands still.
pub fn signal(pid: impl Display, name: &str) -> bool {
    let sent = Command::new("kill")
        .args(["-s", name, &pid.to_string()])
        .stderr(Stdio::null())
        .status()
        .expect("kill is part of every system")
        .success();
    if sent && name == "STOP" {
        until("all threads of the process have stopped", || stands_still(&pid));
    }
    sent
}

/// Whether each thread of the process is stopped or has ended. The state is the field behind the
/// command's name, which stands in parentheses and may hold any character (proc_pid_stat(5)).
fn stands_still(pid: &impl Display) -> bool {
    let Ok(threads) = fs::read_dir(format!("/proc/{pid}/task")) else { return true };
    threads.flatten().all(|thread| {
        let Ok(line) = fs::read_to_string(thread.path().join("stat")) else { return true };
        let state =
            line.rsplit_once(')').and_then(|(_, fields)| fields.trim_start().chars().next());
        matches!(state, Some('T' | 'Z' | 'X'))
    })
}

#[cfg(test)]
mod tests {
    use super::{signal, stands_still};
    use std::process::Command;

    #[test]
    fn after_a_stop_each_thread_stands_still_and_a_process_that_is_gone_is_not_reached() {
        let mut child = Command::new("sleep").arg("1000").spawn().unwrap();
        assert!(!stands_still(&std::process::id()), "this test runs");
        assert!(signal(child.id(), "STOP"));
        assert!(stands_still(&child.id()));
        assert!(signal(child.id(), "KILL"));
        child.wait().unwrap();
        assert!(!signal(child.id(), "CONT"));
    }
}
