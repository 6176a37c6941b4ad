//! The socket between the program and the daemon: requests, one after the other.
//!
//! `daemon/embedding/src/wire.rs` documents the messages.

use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;

use genom_lockstep::{self as lockstep, Caller, DONE, Lost};
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

/// The program's end.
#[derive(Debug)]
pub(crate) struct Door {
    caller: Caller,
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
        Ok((Self { caller: Caller::new(Arc::new(ours)) }, theirs))
    }

    /// Asks, and waits for the reply.
    pub(crate) fn ask(&mut self, verb: Verb, body: &[u8]) -> Result<Reply<'_>, NoReply> {
        done(self.caller.ask(verb as u32, body, None))
    }

    /// Advances the clock; returns its time.
    pub(crate) fn step(&mut self, nanoseconds: u64) -> Result<u64, NoReply> {
        let reply = done(self.caller.ask_short(Verb::Step as u32, Some(nanoseconds)))?;
        reply.u64(0).ok_or(NoReply::Closed)
    }

    /// Ends the conversation: the daemon stops.
    pub(crate) fn close(&self) {
        // It may be closed already.
        let _ = shutdown(&**self.caller.socket(), Shutdown::Both);
    }
}

/// What was done.
fn done(replied: Result<lockstep::Reply<'_>, Lost>) -> Result<Reply<'_>, NoReply> {
    match replied {
        Ok(reply) if reply.status == DONE => Ok(Reply { body: reply.body, file: reply.file }),
        Ok(reply) => Err(NoReply::Refused(reason(reply.body))),
        // Closed, or by something that is no genomd.
        Err(Lost) => Err(NoReply::Closed),
    }
}

fn reason(text: &[u8]) -> Reason {
    let refusal = serde_json::from_slice::<Refusal>(text);
    refusal.map_or_else(|error| Reason::new("malformed", error.to_string()), |read| read.error)
}
