//! The socket between the program and the daemon: requests, one after the other.
//!
//! `daemon/embedding/src/wire.rs` documents the messages.

use std::io::{self, IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;

use genom_protocol::{Reason, Refusal};
use rustix::io::Errno;
use rustix::net::{
    AddressFamily, RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer,
    SendFlags, Shutdown, SocketFlags, SocketType, recvmsg, sendmsg, shutdown, socketpair,
};

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Verb {
    Hello = 0,
    Step = 1,
    Open = 2,
    Close = 3,
}

/// No reply is longer.
const ROOM: usize = 65536;

/// Number and status of a reply.
const HEAD: usize = 8;

/// The program's end.
#[derive(Debug)]
pub(crate) struct Door {
    socket: OwnedFd,
    number: u32,
    room: Vec<u8>,
}

/// Why there is no reply.
#[derive(Debug)]
pub(crate) enum NoReply {
    /// The daemon has closed its end.
    Closed,
    /// It refused.
    Refused(Reason),
}

/// What a request returns.
pub(crate) struct Reply<'a> {
    pub(crate) body: &'a [u8],
    pub(crate) file: Option<OwnedFd>,
}

impl Reply<'_> {
    /// The number at this place.
    pub(crate) fn u32(&self, at: usize) -> Option<u32> {
        self.body.get(at..)?.first_chunk().map(|bytes| u32::from_ne_bytes(*bytes))
    }

    /// The long number at this place.
    pub(crate) fn u64(&self, at: usize) -> Option<u64> {
        self.body.get(at..)?.first_chunk().map(|bytes| u64::from_ne_bytes(*bytes))
    }
}

impl Door {
    /// A pair: the program's end, and the daemon's.
    pub(crate) fn new() -> io::Result<(Self, OwnedFd)> {
        let flags = SocketFlags::CLOEXEC;
        let (ours, theirs) = socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None)?;
        Ok((Self { socket: ours, number: 0, room: vec![0; ROOM] }, theirs))
    }

    /// Asks, and waits for the reply.
    pub(crate) fn ask(&mut self, verb: Verb, body: &[u8]) -> Result<Reply<'_>, NoReply> {
        self.number = self.number.wrapping_add(1);
        let head = [self.number.to_ne_bytes(), (verb as u32).to_ne_bytes()];
        let parts = [IoSlice::new(head.as_flattened()), IoSlice::new(body)];
        let none = &mut SendAncillaryBuffer::default();
        while let Err(error) = sendmsg(&self.socket, &parts, none, SendFlags::NOSIGNAL) {
            if error != Errno::INTR {
                return Err(NoReply::Closed);
            }
        }
        let (count, file) = self.receive().map_err(|_| NoReply::Closed)?;
        let reply = Reply { body: &self.room[..count], file };
        match (reply.u32(0), reply.u32(4)) {
            (Some(number), Some(0)) if number == self.number => {
                Ok(Reply { body: &reply.body[HEAD..], file: reply.file })
            }
            (Some(number), Some(_)) if number == self.number => {
                Err(NoReply::Refused(reason(&reply.body[HEAD..])))
            }
            // Closed, or by something that is no genomd.
            _ => Err(NoReply::Closed),
        }
    }

    /// Ends the conversation: the daemon stops.
    pub(crate) fn close(&self) {
        // It may be closed already.
        let _ = shutdown(&self.socket, Shutdown::Both);
    }

    fn receive(&mut self) -> Result<(usize, Option<OwnedFd>), Errno> {
        let mut space = [MaybeUninit::uninit(); rustix::cmsg_space!(ScmRights(1))];
        let mut ancillary = RecvAncillaryBuffer::new(&mut space);
        let count = loop {
            let mut parts = [IoSliceMut::new(&mut self.room)];
            match recvmsg(&self.socket, &mut parts, &mut ancillary, RecvFlags::CMSG_CLOEXEC) {
                Err(Errno::INTR) => {}
                received => break received?.bytes,
            }
        };
        let file = ancillary.drain().find_map(|message| match message {
            RecvAncillaryMessage::ScmRights(mut files) => files.next(),
            _ => None,
        });
        Ok((count, file))
    }
}

fn reason(text: &[u8]) -> Reason {
    let refusal = serde_json::from_slice::<Refusal>(text);
    refusal.map_or_else(|error| Reason::new("malformed", error.to_string()), |read| read.error)
}
