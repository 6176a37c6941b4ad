//! Processes that codels of a cell started, and that outlive it: none may stay when it has ended.
//!
//! A cell leads a process group of its own, which its descendants are in unless they leave it
//! (`setsid`, as daemons do). All of them have a variable in their environment that names the cell
//! ([`MARK`]), unless a program was executed with another environment.

use std::fs;
use std::io;
use std::os::unix::ffi::OsStrExt as _;

use rustix::process::{Pid, PidfdFlags, Signal, kill_process_group, pidfd_open, pidfd_send_signal};

use crate::place::Place;

/// Variable of the environment with the directory of the cell.
pub(crate) const MARK: &str = "GENOMD_CELL";

/// How often to look again for what was forked while the others were killed.
const ROUNDS: usize = 100;

/// Kills what is left in the process group of a cell whose own process has ended.
pub(crate) fn end_group(leader: Pid) {
    let stat = fs::read_to_string(format!("/proc/{leader}/stat"));
    // Its name, in brackets, may contain anything.
    let state = stat.as_deref().ok().and_then(|text| text.rsplit(") ").next());
    // A process that lives under this number is another one, which was given it since.
    if state.is_none_or(|state| state.starts_with(['Z', 'X'])) {
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
        let Ok(environment) = fs::read(entry.path().join("environ")) else { continue };
        if environment.split(|byte| *byte == 0).any(|one| one == mark) {
            any |= pidfd_send_signal(handle, Signal::KILL).is_ok();
        }
    }
    Ok(any)
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
            command.arg("1000").env(MARK, place.directory()).process_group(0).spawn().unwrap()
        };
        let (mut gone, mut stays) = (start(&place), start(&other));
        end_descendants(&place);
        assert!(gone.wait().unwrap().code().is_none(), "killed");
        assert!(stays.try_wait().unwrap().is_none(), "of another cell");
        stays.kill().unwrap();
        stays.wait().unwrap();
    }
}
