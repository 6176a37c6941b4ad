//! The standard input of a cell: a socket that its daemon holds open as long as it lives, and over
//! which it lends the cell the memory of its black box.

use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, OwnedFd};
use std::os::unix::net::UnixStream;

use genom_blackbox::Memory;
use genom_host::keep_from_children;
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendAncillaryMessage, SendFlags, recvmsg, sendmsg,
};

/// What goes with the memory: a message has one byte at least.
const BYTE: [u8; 1] = [0];

/// What a cell got from its daemon.
#[derive(Debug)]
pub struct Lease {
    /// Closed when the daemon ends.
    pub(crate) daemon: OwnedFd,
    /// The memory of its black box, until it is taken.
    pub memory: Option<Memory>,
}

/// The two ends of a lease, the daemon's first; the memory waits in it for the cell.
pub(crate) fn lend(memory: Option<&Memory>) -> io::Result<(UnixStream, OwnedFd)> {
    let (ours, theirs) = UnixStream::pair()?;
    if let Some(memory) = memory {
        let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut ancillary = SendAncillaryBuffer::new(&mut room);
        let files = [memory.as_fd()];
        ancillary.push(SendAncillaryMessage::ScmRights(&files));
        sendmsg(&ours, &[IoSlice::new(&BYTE)], &mut ancillary, SendFlags::NOSIGNAL)?;
    }
    Ok((ours, theirs.into()))
}

impl Lease {
    /// Takes what a daemon lent; one of an earlier version gave a pipe.
    pub(crate) fn new(daemon: OwnedFd) -> Self {
        let memory = lent(&daemon).ok().flatten();
        if let Some(memory) = &memory {
            keep_from_children(memory);
        }
        Self { daemon, memory }
    }
}

fn lent(daemon: impl AsFd) -> io::Result<Option<Memory>> {
    let mut room = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
    let mut ancillary = RecvAncillaryBuffer::new(&mut room);
    let mut byte = [0];
    let flags = RecvFlags::DONTWAIT | RecvFlags::CMSG_CLOEXEC;
    recvmsg(daemon, &mut [IoSliceMut::new(&mut byte)], &mut ancillary, flags)?;
    let mut files = ancillary.drain().filter_map(|message| match message {
        RecvAncillaryMessage::ScmRights(files) => Some(files),
        _ => None,
    });
    let file = files.next().and_then(|mut files| files.next());
    file.map(|file| Memory::of(file).map_err(io::Error::other)).transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_memory_reaches_the_other_end_and_a_pipe_brings_none() {
        let memory = Memory::new(1 << 20).unwrap();
        let (_ours, theirs) = lend(Some(&memory)).unwrap();
        let lease = Lease::new(theirs);
        assert_eq!(lease.memory.map(|memory| memory.bytes()), Some(1 << 20));
        let (_ours, theirs) = lend(None).unwrap();
        assert!(Lease::new(theirs).memory.is_none());
        let (pipe, _other) = std::io::pipe().unwrap();
        assert!(Lease::new(pipe.into()).memory.is_none());
    }
}
