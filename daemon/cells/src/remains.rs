//! Processes that codels of a cell started, and that outlive it: none may stay when it has ended.
//!
//! A cell leads a process group of its own, which its descendants are in unless they leave it
//! (`setsid`, as daemons do). All of them have a variable in their environment that names the cell
//! ([`MARK`]), unless a program was executed with another environment.

use std::fs;
use std::io;
use std::os::fd::{AsFd as _, BorrowedFd};
use std::os::unix::ffi::OsStrExt as _;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open, pidfd_send_signal};

use crate::place::Place;
use crate::stat::Stat;

/// Variable of the environment with the directory of the cell.
pub(crate) const MARK: &str = "GENOMD_CELL";

/// How often to look again for what was forked while the others were killed.
const ROUNDS: usize = 100;

/// How often, and how long each time, to wait for a process that executes a program.
const TRIES: usize = 1000;
const TRY: Timespec = Timespec { tv_sec: 0, tv_nsec: 1_000_000 };

/// Kills what is left in the process group of a cell whose own process has ended.
pub(crate) fn end_group(leader: Pid) {
    let stat = Stat::of(leader);
    // A process that lives under this number is another one, which was given it since.
    if stat
        .as_ref()
        .and_then(|stat| stat.field(3))
        .is_none_or(|state| state.starts_with(['Z', 'X']))
    {
        let _ = kill_process_group(leader, Signal::KILL);
    }
}

/// Kills all that was started from a cell that has no process of its own now.
pub(crate) fn end_descendants(place: &Place) {
    let mut mark = format!("{MARK}=").into_bytes();
    mark.extend(place.directory().as_os_str().as_bytes());
    for _ in 0..ROUNDS {
        let found = marked(&mark);
        if !found.unwrap_or(false) {
            return;
        }
    }
    tracing::error!("{}: processes of this cell stay", place.directory().display());
}

/// Kills the processes with this variable; whether there were any.
fn marked(mark: &[u8]) -> io::Result<bool> {
    let mut any = false;
    for entry in fs::read_dir("/proc")?.flatten() {
        let number = entry.file_name().to_str().and_then(|name| name.parse().ok());
        let Some(pid) = number.and_then(Pid::from_raw) else { continue };
        // Held first, so that the number stays that of the process whose environment is read.
        let Ok(handle) = pidfd_open(pid, PidfdFlags::empty()) else { continue };
        let Some(environment) = environment(pid, handle.as_fd()) else { continue };
        if environment.split(|byte| *byte == 0).any(|one| one == mark) {
            any |= pidfd_send_signal(handle, Signal::KILL).is_ok();
        }
    }
    Ok(any)
}

/// The environment of a process; nothing of one that has ended, or that may not be looked at.
fn environment(pid: Pid, handle: BorrowedFd<'_>) -> Option<Vec<u8>> {
    for _ in 0..TRIES {
        let before = end_of_environment(pid)?;
        let environment = fs::read(format!("/proc/{pid}/environ")).ok()?;
        // `execve` first drops the memory of the old program, and writes the environment of the new
        // one later: what is read in between is empty.
        if before != 0 && before == end_of_environment(pid)? {
            return Some(environment);
        }
        // A process that ends is waited for no longer.
        let _ = poll(&mut [PollFd::new(&handle, PollFlags::IN)], Some(&TRY));
    }
    None
}

/// Address behind the environment in the memory of a process (`env_end` of proc_pid_stat(5)): 0 while
/// it has none yet. `None` of a process without memory: one of the kernel's, or one that has ended.
fn end_of_environment(pid: Pid) -> Option<u64> {
    let stat = Stat::of(pid)?;
    let field = |number| stat.field(number)?.parse::<u64>().ok();
    let memory = field(23)?;
    if memory == 0 { None } else { field(51) }
}

#[cfg(test)]
mod tests {
    use std::os::unix::process::CommandExt as _;
    use std::process::Command;

    use super::*;

    #[test]
    fn what_a_cell_left_is_killed_wherever_it_went_and_nothing_else() {
        let scratch = tempfile::tempdir().unwrap();
        let place = Place::new(scratch.path(), "arm").unwrap();
        let other = Place::new(scratch.path(), "arm2").unwrap();
        let start = |place: &Place| {
            let mut command = Command::new("/bin/sleep");
            command.arg("60").env(MARK, place.directory()).process_group(0).spawn().unwrap()
        };
        let (mut gone, mut stays) = (start(&place), start(&other));
        end_descendants(&place);
        assert!(gone.wait().unwrap().code().is_none(), "killed");
        assert!(stays.try_wait().unwrap().is_none(), "of another cell");
        stays.kill().unwrap();
        stays.wait().unwrap();
    }

    #[test]
    fn a_process_that_executes_a_program_meanwhile_is_seen() {
        let scratch = tempfile::tempdir().unwrap();
        let place = Place::new(scratch.path(), "arm").unwrap();
        for _ in 0..100 {
            // Returns while `execve` is still at work, before there is an environment to read.
            let mut sleep = Command::new("/bin/sleep");
            let mut child = sleep.arg("60").env(MARK, place.directory()).spawn().unwrap();
            let mark = format!("{MARK}={}", place.directory().display());
            let pid = Pid::from_child(&child);
            let handle = pidfd_open(pid, PidfdFlags::empty()).unwrap();
            let read = environment(pid, handle.as_fd()).unwrap();
            child.kill().unwrap();
            child.wait().unwrap();
            assert!(read.split(|byte| *byte == 0).any(|one| one == mark.as_bytes()));
        }
    }
}
