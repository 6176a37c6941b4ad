//! Short requests: the slate on which they come, and what the last one of them returned.

use std::fs::File;
use std::io;

use genom_doors::RpcError;
use genom_lockstep::{Answer, DONE, Slate};
use genom_protocol::Code;

use crate::wire::REFUSED;

/// What a step returns: the time, and how many ports are not there.
pub(crate) type Returned = (u64, u32);

pub(crate) struct Short {
    pub(crate) slate: Slate,
    /// Number of the last request, and what it returned, unless that was told since.
    last: Option<(u32, Result<Returned, RpcError>)>,
}

impl Short {
    /// With a new slate, and its file.
    pub(crate) fn new() -> io::Result<(Self, File)> {
        let (slate, file) = Slate::new()?;
        Ok((Self { slate, last: None }, file))
    }

    /// Answers the request of this number. Why it was refused does not fit on the slate: that is told
    /// to who asks for it.
    pub(crate) fn answer(&mut self, number: u32, returned: Result<Returned, RpcError>) {
        let status = if returned.is_ok() { DONE } else { REFUSED };
        let (first, second) = *returned.as_ref().unwrap_or(&(0, 0));
        self.slate.answer(number, Answer { status, first, second });
        self.last = Some((number, returned));
    }

    /// What the request of this number returned, if it is the last one; once.
    pub(crate) fn tell(&mut self, number: u32) -> Result<Returned, RpcError> {
        match self.last.take() {
            Some((last, returned)) if last == number => returned,
            _ => Err(untold(number)),
        }
    }
}

/// Nothing is known of the request of this number.
pub(crate) fn untold(number: u32) -> RpcError {
    let message = format!("the last request on the slate is not {number}, or was told");
    RpcError::conflict(Code::Malformed, message)
}
