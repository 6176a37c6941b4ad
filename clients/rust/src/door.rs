//! The socket between the program and the daemon: requests, one after the other.
//!
//! `daemon/embedding/src/wire.rs` documents the messages.

use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;

use genom_lockstep::End;
use genom_protocol::{Reason, Refusal};
use rustix::net::{AddressFamily, Shutdown, SocketFlags, SocketType, shutdown, socketpair};

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
    end: End,
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
        let end = End::new(Arc::new(ours));
        Ok((Self { end, number: 0, room: vec![0; ROOM] }, theirs))
    }

    /// Asks, and waits for the reply.
    pub(crate) fn ask(&mut self, verb: Verb, body: &[u8]) -> Result<Reply<'_>, NoReply> {
        self.number = self.number.wrapping_add(1);
        let head = [self.number.to_ne_bytes(), (verb as u32).to_ne_bytes()];
        self.end.send([head.as_flattened(), body], None).map_err(|_| NoReply::Closed)?;
        let (count, file) = self.end.receive(&mut self.room).map_err(|_| NoReply::Closed)?;
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
        let _ = shutdown(&**self.end.socket(), Shutdown::Both);
    }
}

fn reason(text: &[u8]) -> Reason {
    let refusal = serde_json::from_slice::<Refusal>(text);
    refusal.map_or_else(|error| Reason::new("malformed", error.to_string()), |read| read.error)
}
