//! The end of a process, seen before all of it has ended.
//!
//! A process that a signal ends is gone when its last thread is and its memory was given back: that
//! takes milliseconds, and only then its descriptor (`pidfd`) tells. Each of its other threads ends
//! at once, and by then the kernel tells what the process ends with.

use std::fs;
use std::os::fd::OwnedFd;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, pidfd_open};

use crate::end::End;
use crate::stat::Stat;

/// Name of a thread that a cell has from its beginning to its end.
const LASTING: &str = "genomd-rpc";

/// How often to look whether a process that starts has it, and for how long: 10 s.
const LOOK: Timespec = Timespec { tv_sec: 0, tv_nsec: 20_000_000 };
const LOOKS: usize = 500;

/// Number of the field with the exit code in `/proc/PID/stat`.
const EXIT_CODE: usize = 52;

/// Waits until a process has ended, or is seen to end by a fault; then says how. `None` also where
/// threads have no descriptors, before Linux 6.9.
pub(crate) fn failure(pid: Pid, process: &OwnedFd) -> Option<End> {
    fails(pid, &lasting(pid, process)?, process)
}

fn fails(pid: Pid, thread: &OwnedFd, process: &OwnedFd) -> Option<End> {
    let mut both = [PollFd::new(thread, PollFlags::IN), PollFd::new(process, PollFlags::IN)];
    while let Err(Errno::INTR) = poll(&mut both, None) {}
    ends_with(pid).filter(End::is_failure)
}

/// The thread that lasts, once there is one. Not the first one: of that the kernel tells no sooner
/// than of the process (since Linux 6.15).
fn lasting(pid: Pid, process: &OwnedFd) -> Option<OwnedFd> {
    // `PIDFD_THREAD`.
    let of_thread = PidfdFlags::from_bits_retain(OFlags::EXCL.bits());
    for _ in 0..LOOKS {
        if let Some(thread) = thread_of(pid) {
            return pidfd_open(thread, of_thread).ok();
        }
        let ended = poll(&mut [PollFd::new(process, PollFlags::IN)], Some(&LOOK));
        if !matches!(ended, Ok(0) | Err(Errno::INTR)) {
            return None;
        }
    }
    None
}

fn thread_of(pid: Pid) -> Option<Pid> {
    let all = fs::read_dir(format!("/proc/{pid}/task")).ok()?.flatten();
    let named = all.filter(|task| {
        fs::read_to_string(task.path().join("comm")).is_ok_and(|name| name.trim_end() == LASTING)
    });
    let numbers = named.filter_map(|task| task.file_name().to_str()?.parse().ok());
    let others = numbers.filter(|number: &i32| *number != pid.as_raw_nonzero().get());
    others.min().and_then(Pid::from_raw)
}

/// What a process ends with that may not have ended in all its parts; `None` if it is not known to
/// end, or by itself and in order.
fn ends_with(pid: Pid) -> Option<End> {
    let stat = Stat::of(pid)?;
    // Of one that is stopped, the signal that stopped it stands there.
    if stat.field(3).is_none_or(|state| state.eq_ignore_ascii_case("t")) {
        return None;
    }
    let code: i32 = stat.field(EXIT_CODE)?.parse().ok()?;
    // As `wait` tells it.
    match (code & 0x7f, code >> 8) {
        (0, 0) | (0x7f, _) => None,
        (0, status) => Some(End::Exited(status)),
        (signal, _) => Some(End::Signal(signal)),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;
    use std::process::{Command, Stdio};

    use super::*;

    /// Ends when it is told to, with a thread of the name beside its first one.
    const PROGRAM: &str = "import ctypes, os, sys, threading\n\
        name = lambda: ctypes.CDLL(None).prctl(15, b'genomd-rpc', 0, 0, 0)\n\
        threading.Thread(target=lambda: (name(), threading.Event().wait()), daemon=True).start()\n\
        sys.stdin.readline()\n\
        exec(sys.argv[1])\n";

    #[test]
    fn what_a_process_ends_with_is_known_before_its_status_is_taken() {
        for (end, wanted) in [
            ("os._exit(3)", Some(End::Exited(3))),
            ("os.kill(os.getpid(), 9)", Some(End::Signal(9))),
            ("os._exit(0)", None),
        ] {
            let mut command = Command::new("python3");
            let mut child =
                command.args(["-c", PROGRAM, end]).stdin(Stdio::piped()).spawn().unwrap();
            let pid = Pid::from_child(&child);
            let process = pidfd_open(pid, PidfdFlags::empty()).unwrap();
            let thread = lasting(pid, &process);
            child.stdin.take().unwrap().write_all(b"now\n").unwrap();
            // Before Linux 6.9 there is none.
            if let Some(thread) = thread {
                assert_eq!(fails(pid, &thread, &process), wanted, "{end}");
            }
            child.wait().unwrap();
        }
    }

    #[test]
    fn a_process_that_runs_ends_with_nothing() {
        let own = Pid::from_raw(std::process::id().cast_signed()).unwrap();
        assert_eq!(ends_with(own), None);
    }
}
