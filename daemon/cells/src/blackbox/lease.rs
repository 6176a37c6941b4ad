//! The standard input of a cell: a socket that its daemon holds open as long as it lives. With it
//! come the memory of the cell's black box, a socket at whose other end dumps are taken, and one over
//! which the daemon of a program steps the cell.

use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::net::UnixStream;

use genom_blackbox::Memory;
use genom_host::keep_from_children;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, sendmsg,
};

/// What comes with a lease, in the one byte of its message.
const MEMORY: u8 = 1;
const DUMPER: u8 = 2;
const STEPS: u8 = 4;

/// What a cell got from its daemon.
#[derive(Debug)]
pub struct Lease {
    /// Closed when the daemon ends.
    pub(crate) daemon: OwnedFd,
    /// The memory of its black box, until it is taken.
    pub(crate) memory: Option<Memory>,
    /// Where dumps are taken when it crashes, until it is taken.
    pub dumper: Option<OwnedFd>,
    /// Where its daemon steps it, until it is taken.
    pub steps: Option<OwnedFd>,
}

/// What a daemon lends a cell.
#[derive(Debug, Default)]
pub(crate) struct Lent<'a> {
    /// The memory of its black box.
    pub(crate) memory: Option<&'a Memory>,
    /// An end of a socket.
    pub(crate) dumper: Option<BorrowedFd<'a>>,
    /// An end of a socket.
    pub(crate) steps: Option<BorrowedFd<'a>>,
}

/// The two ends of a lease, the daemon's first; what comes with it waits there for the cell.
pub(crate) fn lend(lent: &Lent<'_>) -> io::Result<(UnixStream, OwnedFd)> {
    let (ours, theirs) = UnixStream::pair()?;
    let &Lent { memory, dumper, steps } = lent;
    let files = memory.map(AsFd::as_fd).into_iter().chain(dumper).chain(steps);
    let files: Vec<BorrowedFd<'_>> = files.collect();
    if !files.is_empty() {
        let with = |there: bool, bit: u8| if there { bit } else { 0 };
        let byte = [with(memory.is_some(), MEMORY)
            | with(dumper.is_some(), DUMPER)
            | with(steps.is_some(), STEPS)];
        let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(3))];
        let mut ancillary = SendAncillaryBuffer::new(&mut room);
        ancillary.push(SendAncillaryMessage::ScmRights(&files));
        sendmsg(&ours, &[IoSlice::new(&byte)], &mut ancillary, SendFlags::NOSIGNAL)?;
    }
    Ok((ours, theirs.into()))
}

impl Lease {
    /// Takes what a daemon lent; one of an earlier version gave a pipe.
    pub(crate) fn new(daemon: OwnedFd) -> Self {
        let (memory, dumper, steps) = lent(&daemon).unwrap_or_default();
        if let Some(memory) = &memory {
            keep_from_children(memory);
        }
        if let Some(steps) = &steps {
            keep_from_children(steps);
        }
        Self { daemon, memory, dumper, steps }
    }
}

type Found = (Option<Memory>, Option<OwnedFd>, Option<OwnedFd>);

fn lent(daemon: impl AsFd) -> io::Result<Found> {
    let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(3))];
    let mut ancillary = RecvAncillaryBuffer::new(&mut room);
    let mut byte = [0];
    let flags = RecvFlags::DONTWAIT | RecvFlags::CMSG_CLOEXEC;
    recvmsg(daemon, &mut [IoSliceMut::new(&mut byte)], &mut ancillary, flags)?;
    let mut files = ancillary.drain().filter_map(|message| match message {
        RecvAncillaryMessage::ScmRights(files) => Some(files),
        _ => None,
    });
    let mut files = files.next().into_iter().flatten();
    let mut next = |bit: u8| (byte[0] & bit != 0).then(|| files.next()).flatten();
    let memory = next(MEMORY).map(|file| Memory::of(file).map_err(io::Error::other));
    Ok((memory.transpose()?, next(DUMPER), next(STEPS)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_lent_reaches_the_other_end_and_a_pipe_brings_nothing() {
        let memory = Memory::new(1 << 20).unwrap();
        let (_dumps, dumper) = UnixStream::pair().unwrap();
        for which in 0..8_u8 {
            let lent = Lent {
                memory: (which & MEMORY != 0).then_some(&memory),
                dumper: (which & DUMPER != 0).then_some(dumper.as_fd()),
                steps: (which & STEPS != 0).then_some(dumper.as_fd()),
            };
            let (_ours, theirs) = lend(&lent).unwrap();
            let lease = Lease::new(theirs);
            let bytes = lent.memory.map(Memory::bytes);
            assert_eq!(lease.memory.map(|memory| memory.bytes()), bytes);
            let there = (lease.dumper.is_some(), lease.steps.is_some());
            assert_eq!(there, (lent.dumper.is_some(), lent.steps.is_some()));
        }
        let (pipe, _other) = std::io::pipe().unwrap();
        assert!(Lease::new(pipe.into()).memory.is_none());
    }
}
