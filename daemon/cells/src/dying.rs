//! The end of a process, seen before all of it has ended.
//!
//! A process that a signal ends is gone when its last thread is and its memory was given back: that
//! takes milliseconds, and only then its descriptor (`pidfd`) tells. Its first thread ends at once,
//! and from then on the kernel tells what the process ends with.

use std::fs;
use std::os::fd::OwnedFd;

use rustix::event::{PollFd, PollFlags, poll};
use rustix::fs::OFlags;
use rustix::io::Errno;
use rustix::process::{Pid, PidfdFlags, pidfd_open};

use crate::end::End;

/// Place of the exit code in `/proc/PID/stat`, counted from the state, which follows the name.
const EXIT_CODE: usize = 49;

/// The first thread of a process.
pub(crate) struct Dying {
    pid: Pid,
    /// `None` before Linux 6.9, which has no descriptors of threads.
    thread: Option<OwnedFd>,
}

impl Dying {
    /// Of a process that nobody else takes the status of meanwhile.
    pub(crate) fn of(pid: Pid) -> Self {
        // `PIDFD_THREAD`.
        let of_thread = PidfdFlags::from_bits_retain(OFlags::EXCL.bits());
        Self { pid, thread: pidfd_open(pid, of_thread).ok() }
    }

    /// Waits until the process has ended, or is seen to end by a fault; then says how.
    pub(crate) fn failure(&self, process: &OwnedFd) -> Option<End> {
        let thread = self.thread.as_ref()?;
        let mut both = [PollFd::new(thread, PollFlags::IN), PollFd::new(process, PollFlags::IN)];
        while let Err(Errno::INTR) = poll(&mut both, None) {}
        ends_with(self.pid).filter(End::is_failure)
    }
}

/// What a process ends with that has not ended in all its parts; `None` if it is not known to end,
/// or by itself and in order.
fn ends_with(pid: Pid) -> Option<End> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // Its name, in brackets, may contain anything.
    let mut words = stat.rsplit(") ").next()?.split_ascii_whitespace();
    if words.next() != Some("Z") {
        return None;
    }
    let code: i32 = words.nth(EXIT_CODE - 1)?.parse().ok()?;
    // As `wait` tells it.
    match (code & 0x7f, code >> 8) {
        (0, 0) => None,
        (0, status) => Some(End::Exited(status)),
        (0x7f, _) => None,
        (signal, _) => Some(End::Signal(signal)),
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    #[test]
    fn what_a_process_ends_with_is_known_before_its_status_is_taken() {
        for (script, wanted) in [
            ("exit 3", Some(End::Exited(3))),
            ("kill -KILL $$", Some(End::Signal(9))),
            ("ulimit -c 0; kill -SEGV $$", Some(End::Signal(11))),
            ("exit 0", None),
        ] {
            let mut child = Command::new("/bin/sh").args(["-c", script]).spawn().unwrap();
            let pid = Pid::from_child(&child);
            let process = pidfd_open(pid, PidfdFlags::empty()).unwrap();
            let dying = Dying::of(pid);
            let seen = dying.failure(&process);
            assert_eq!(seen, wanted.filter(|_| dying.thread.is_some()), "{script}");
            child.wait().unwrap();
        }
        let own = Pid::from_raw(std::process::id().cast_signed()).unwrap();
        assert_eq!(ends_with(own), None);
    }
}
