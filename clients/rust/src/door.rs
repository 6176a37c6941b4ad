//! The socket between the program and the daemon: requests, one after the other.
//!
//! `daemon/embedding/src/wire.rs` documents the messages.

use std::io;
use std::os::fd::OwnedFd;
use std::sync::Arc;

use genom_lockstep::{Caller, NotDone, Reply};
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

impl From<NotDone<'_>> for NoReply {
    fn from(not: NotDone<'_>) -> Self {
        match not {
            // Closed, or by something that is no genomd.
            NotDone::Lost => Self::Closed,
            NotDone::Refused(text) => Self::Refused(reason(text)),
        }
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
        Ok(self.caller.ask(verb as u32, body, None)?)
    }

    /// Advances the clock; returns its time.
    pub(crate) fn step(&mut self, nanoseconds: u64) -> Result<u64, NoReply> {
        let reply = self.caller.ask_short(Verb::Step as u32, Some(nanoseconds))?;
        reply.u64(0).ok_or(NoReply::Closed)
    }

    /// Ends the conversation: the daemon stops.
    pub(crate) fn close(&self) {
        // It may be closed already.
        let _ = shutdown(&**self.caller.socket(), Shutdown::Both);
    }
}

fn reason(text: &[u8]) -> Reason {
    let refusal = serde_json::from_slice::<Refusal>(text);
    refusal.map_or_else(|error| Reason::new("malformed", error.to_string()), |read| read.error)
}
