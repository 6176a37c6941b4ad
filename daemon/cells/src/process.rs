//! The process of a cell: started without a fork, seen to end by its descriptor (`pidfd`).
//!
//! Its end has two moments. First it is *seen*, by one of its threads if it is a fault (`dying`): what
//! must be done of other components is done then. Then it is *over*: what its codels started is
//! ended, and its status taken, so that the next process may start.

use std::fs;
use std::io;
use std::os::fd::{AsFd as _, OwnedFd};
use std::os::unix::net::UnixStream;
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::thread;

use genom_blackbox::Memory;
use genom_kit::prompt::be_prompt;
use rustix::event::{PollFd, PollFlags, poll};
use rustix::io::Errno;
use rustix::net::{AddressFamily, SocketFlags, SocketType, socketpair};
use rustix::process::{
    Pid, PidfdFlags, Signal, WaitId, WaitIdOptions, pidfd_open, pidfd_send_signal, waitid,
};
use tokio::sync::watch;

use crate::blackbox::{Lent, lend};
use crate::crashes::Dump;
use crate::dying;
use crate::end::End;
use crate::place::Place;
use crate::remains;
use crate::theirs;

/// Stack of the thread that waits for an end, in bytes.
const STACK: usize = 64 * 1024;

/// Most bytes of the number of a process.
const LONGEST: u64 = 32;

/// What a process gets beside its files.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gets {
    /// A socket where dumps are taken of it.
    pub(crate) dumps: bool,
    /// A socket over which it is stepped.
    pub(crate) steps: bool,
}

/// The process of a cell, this daemon's child or that of a daemon before it.
#[derive(Debug)]
pub(crate) struct Process {
    pid: Pid,
    handle: Arc<OwnedFd>,
    /// How it ended, once it has.
    seen: watch::Receiver<Option<End>>,
    /// The same, once nothing of it is left.
    over: watch::Receiver<Option<End>>,
    dump: Dump,
    /// Where a daemon that is part of a program steps it.
    steps: Option<Arc<OwnedFd>>,
    /// The other end of its standard input, which the child sees closed when this daemon ends.
    _lease: Option<UnixStream>,
}

impl Process {
    /// Starts this program with `--run-cell NAME` and the files at this place. The child is made by
    /// `posix_spawn`: a fork would copy the page tables of the daemon while its real-time threads
    /// run, which costs them periods. In a process group of its own it gets no signal of the
    /// daemon's terminal.
    pub(crate) fn start(
        mut command: Command,
        name: &str,
        place: &Place,
        memory: Option<&Memory>,
        gets: Gets,
    ) -> io::Result<Self> {
        let dumper = gets.dumps.then(UnixStream::pair).transpose()?;
        let pair =
            || socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None);
        let steps = gets.steps.then(pair).transpose()?;
        let lent = Lent {
            memory,
            dumper: dumper.as_ref().map(|(_, theirs)| theirs.as_fd()),
            steps: steps.as_ref().map(|(_, theirs)| theirs.as_fd()),
        };
        let (lease, theirs) = lend(&lent)?;
        let steps = steps.map(|(ours, _)| Arc::new(ours));
        command
            .arg("--run-cell")
            .arg(name)
            .arg("--config")
            .arg(place.config())
            // The variable by which users choose the daemon's would come before the file.
            .env_remove("GENOMD_SOCKET")
            .env(remains::MARK, place.directory())
            .stdin(theirs)
            .process_group(0);
        if place.temporary().is_dir() {
            command.env("TMPDIR", place.temporary());
        }
        let child = command.spawn().map_err(|error| {
            let program = Path::new(command.get_program()).display();
            io::Error::new(error.kind(), format!("{program}: {error}"))
        })?;
        let pid = Pid::from_child(&child);
        let dump = Dump::default();
        if let Some((ours, theirs)) = dumper {
            drop(theirs);
            dump.await_request(pid.as_raw_nonzero().get(), ours)?;
        }
        // For a daemon that comes after this one, when the cell does not answer it.
        theirs::write(&place.pid(), pid.as_raw_nonzero().to_string().as_bytes())?;
        Ok(Self { dump, steps, ..Self::of(pid, Some(lease), Some(place))? })
    }

    /// Of a process that crashes, what was taken of it.
    pub(crate) fn dump(&self) -> Dump {
        self.dump.clone()
    }

    /// Where it is stepped.
    pub(crate) fn steps(&self) -> Option<Arc<OwnedFd>> {
        self.steps.clone()
    }

    /// A process that another daemon started, or this one before. With a place, what its codels
    /// started and left ends with it; one owner at a time does that.
    pub(crate) fn found(pid: u32, place: Option<&Place>) -> io::Result<Self> {
        let pid = i32::try_from(pid).ok().and_then(Pid::from_raw);
        Self::of(pid.ok_or(Errno::SRCH)?, None, place)
    }

    fn of(pid: Pid, lease: Option<UnixStream>, place: Option<&Place>) -> io::Result<Self> {
        let place = place.cloned();
        let handle = Arc::new(pidfd_open(pid, PidfdFlags::empty())?);
        let (sees, seen) = watch::channel(None);
        let (ends, over) = watch::channel(None);
        let watched = Arc::clone(&handle);
        // A thread, since tokio takes no such descriptor without unsafe code; it sleeps.
        thread::Builder::new().name("cell-end".to_owned()).stack_size(STACK).spawn(move || {
            // Where that is refused, it is only slower.
            let _ = be_prompt();
            if let Some(failure) = dying::failure(pid, &watched) {
                sees.send_replace(Some(failure));
            }
            while let Err(Errno::INTR) = poll(&mut [PollFd::new(&*watched, PollFlags::IN)], None) {}
            let end = status(&watched, WaitIdOptions::NOWAIT);
            sees.send_if_modified(|seen| {
                let first = seen.is_none();
                seen.get_or_insert_with(|| end.clone());
                first
            });
            if let Some(place) = place {
                // Before its status is taken: until then, nobody else gets its number.
                remains::end_group(pid);
                remains::end_descendants(&place);
            }
            let _ = status(&watched, WaitIdOptions::empty());
            ends.send_replace(Some(end));
        })?;
        Ok(Self { pid, handle, seen, over, dump: Dump::default(), steps: None, _lease: lease })
    }

    pub(crate) fn pid(&self) -> u32 {
        self.pid.as_raw_nonzero().get().unsigned_abs()
    }

    /// Waits until it has ended. What its codels started may still run.
    pub(crate) async fn seen(&self) -> End {
        told(self.seen.clone()).await
    }

    /// Waits until nothing of it is left.
    pub(crate) async fn ended(&self) -> End {
        told(self.over.clone()).await
    }

    /// Sends it a signal; one that has ended gets none.
    pub(crate) fn signal(&self, signal: Signal) {
        let _ = pidfd_send_signal(&*self.handle, signal);
    }
}

/// Kills a process; who waits for it, and nobody else, takes its status.
pub(crate) fn kill(pid: u32) -> io::Result<()> {
    let pid = i32::try_from(pid).ok().and_then(Pid::from_raw).ok_or(Errno::SRCH)?;
    let handle = pidfd_open(pid, PidfdFlags::empty())?;
    Ok(pidfd_send_signal(&handle, Signal::KILL)?)
}

async fn told(mut end: watch::Receiver<Option<End>>) -> End {
    let told = end.wait_for(Option::is_some).await;
    told.ok().and_then(|end| end.clone()).unwrap_or(End::Unknown)
}

/// The status of a process that has ended: taken, unless it is to stay (`NOWAIT`).
fn status(handle: &OwnedFd, how: WaitIdOptions) -> End {
    let id = WaitId::PidFd(handle.as_fd());
    match waitid(id, WaitIdOptions::EXITED | WaitIdOptions::NOHANG | how) {
        Ok(Some(status)) => match (status.exit_status(), status.terminating_signal()) {
            (Some(status), _) => End::Exited(status),
            (None, Some(signal)) => End::Signal(signal),
            (None, None) => End::Unknown,
        },
        // It was no child of this process.
        Ok(None) | Err(_) => End::Unknown,
    }
}

/// The process that a dead daemon left at a place, if it still is one of its cells.
pub(crate) fn left(place: &Place, name: &str) -> Option<u32> {
    let pid: u32 = theirs::read(&place.pid(), LONGEST).ok()?.trim().parse().ok()?;
    // The number may have been given to another process since.
    let arguments = fs::read(PathBuf::from(format!("/proc/{pid}/cmdline"))).ok()?;
    let mut words = arguments.split(|byte| *byte == 0);
    let is_cell = words.any(|word| word == b"--run-cell") && words.next() == Some(name.as_bytes());
    let config = place.config();
    let of_place = words.any(|word| word == config.as_os_str().as_encoded_bytes());
    (is_cell && of_place).then_some(pid)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[allow(clippy::zombie_processes, reason = "what is tested waits for it")]
    async fn end_of(script: &str) -> End {
        let child = Command::new("/bin/sh").args(["-c", script]).spawn().unwrap();
        let process = Process::of(Pid::from_child(&child), None, None).unwrap();
        let seen = process.seen().await;
        assert_eq!(process.ended().await, seen);
        seen
    }

    #[tokio::test]
    async fn the_end_of_a_process_is_seen_with_its_status() {
        assert_eq!(end_of("exit 3").await, End::Exited(3));
        assert_eq!(end_of("kill -SEGV $$").await, End::Signal(11));
    }

    #[tokio::test]
    async fn a_number_that_was_given_to_another_process_is_no_cell() {
        let scratch = tempfile::tempdir().unwrap();
        let place = Place::new(scratch.path(), "arm").unwrap();
        place.make().unwrap_err();
        fs::create_dir_all(place.pid().parent().unwrap()).unwrap();
        fs::write(place.pid(), std::process::id().to_string()).unwrap();
        assert_eq!(left(&place, "arm"), None);
    }
}
