//! The standard input of a cell: a socket that its daemon holds open as long as it lives. With it
//! come the memory of the cell's black box, and a socket at whose other end dumps are taken.

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

/// What a cell got from its daemon.
#[derive(Debug)]
pub struct Lease {
    /// Closed when the daemon ends.
    pub(crate) daemon: OwnedFd,
    /// The memory of its black box, until it is taken.
    pub(crate) memory: Option<Memory>,
    /// Where dumps are taken when it crashes, until it is taken.
    pub dumper: Option<OwnedFd>,
}

/// The two ends of a lease, the daemon's first; what comes with it waits there for the cell.
pub(crate) fn lend(
    memory: Option<&Memory>,
    dumper: Option<BorrowedFd<'_>>,
) -> io::Result<(UnixStream, OwnedFd)> {
    let (ours, theirs) = UnixStream::pair()?;
    let files: Vec<BorrowedFd<'_>> = memory.map(AsFd::as_fd).into_iter().chain(dumper).collect();
    if !files.is_empty() {
        let with = |there: bool, bit: u8| if there { bit } else { 0 };
        let byte = [with(memory.is_some(), MEMORY) | with(dumper.is_some(), DUMPER)];
        let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(2))];
        let mut ancillary = SendAncillaryBuffer::new(&mut room);
        ancillary.push(SendAncillaryMessage::ScmRights(&files));
        sendmsg(&ours, &[IoSlice::new(&byte)], &mut ancillary, SendFlags::NOSIGNAL)?;
    }
    Ok((ours, theirs.into()))
}

impl Lease {
    /// Takes what a daemon lent; one of an earlier version gave a pipe.
    pub(crate) fn new(daemon: OwnedFd) -> Self {
        let (memory, dumper) = lent(&daemon).unwrap_or_default();
        if let Some(memory) = &memory {
            keep_from_children(memory);
        }
        Self { daemon, memory, dumper }
    }
}

fn lent(daemon: impl AsFd) -> io::Result<(Option<Memory>, Option<OwnedFd>)> {
    let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(2))];
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
    Ok((memory.transpose()?, next(DUMPER)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_memory_reaches_the_other_end_and_a_pipe_brings_none() {
        let memory = Memory::new(1 << 20).unwrap();
        let (_dumps, dumper) = UnixStream::pair().unwrap();
        for (dumps, is) in [(None, false), (Some(dumper.as_fd()), true)] {
            let (_ours, theirs) = lend(Some(&memory), dumps).unwrap();
            let lease = Lease::new(theirs);
            assert_eq!(lease.memory.map(|memory| memory.bytes()), Some(1 << 20));
            assert_eq!(lease.dumper.is_some(), is);
            let (_ours, theirs) = lend(None, dumps).unwrap();
            let lease = Lease::new(theirs);
            assert_eq!((lease.memory.is_none(), lease.dumper.is_some()), (true, is));
        }
        let (pipe, _other) = std::io::pipe().unwrap();
        assert!(Lease::new(pipe.into()).memory.is_none());
    }
}
