//! The end that asks. A request is a message of `u32` number, `u32` verb, and what the verb takes; its
//! reply has the same number, `u32` status, 0 for done, and what the verb returns. Numbers are in the
//! order of the machine. What the verbs are is for both ends to know, except for [`SLATE`] and [`TELL`].

use std::os::fd::{BorrowedFd, OwnedFd};
use std::sync::Arc;

use crate::end::{End, Replied};
use crate::slate::{Answer, Asked, Slate};

/// The verb that asks for the file of a [`Slate`].
pub const SLATE: u32 = 6;

/// The verb that asks what a request on the slate returns: it takes the `u32` number of that request.
pub const TELL: u32 = 7;

/// The status of what is done.
pub const DONE: u32 = 0;

/// No reply is longer.
const ROOM: usize = 65536;

/// Number and status of a reply.
const HEAD: usize = 8;

/// Asks, and waits for replies: one at a time.
#[derive(Debug)]
pub struct Caller {
    end: End,
    number: u32,
    room: Vec<u8>,
    /// None if the other end refuses it, and before it was asked.
    slate: Option<Slate>,
    has_asked: bool,
}

/// What was done returns this.
#[derive(Debug)]
pub struct Reply<'a> {
    /// What the verb returns.
    pub body: &'a [u8],
    /// What came with it.
    pub file: Option<OwnedFd>,
}

/// Why nothing was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotDone<'a> {
    /// The other end is closed, or answers what is no answer.
    Lost,
    /// It refused, and says this.
    Refused(&'a [u8]),
}

impl Reply<'_> {
    /// The number at this place.
    #[must_use]
    pub fn u32(&self, at: usize) -> Option<u32> {
        self.body.get(at..)?.first_chunk().map(|bytes| u32::from_ne_bytes(*bytes))
    }

    /// The long number at this place.
    #[must_use]
    pub fn u64(&self, at: usize) -> Option<u64> {
        self.body.get(at..)?.first_chunk().map(|bytes| u64::from_ne_bytes(*bytes))
    }
}

impl Caller {
    /// At this end.
    #[must_use]
    pub fn new(socket: Arc<OwnedFd>) -> Self {
        let (end, room) = (End::new(socket), vec![0; ROOM]);
        Self { end, number: 0, room, slate: None, has_asked: false }
    }

    /// Its socket.
    #[must_use]
    pub fn socket(&self) -> &Arc<OwnedFd> {
        self.end.socket()
    }

    /// Asks by message.
    ///
    /// # Errors
    /// It was not done.
    pub fn ask(
        &mut self,
        verb: u32,
        body: &[u8],
        file: Option<BorrowedFd<'_>>,
    ) -> Result<Reply<'_>, NotDone<'_>> {
        self.number = self.number.wrapping_add(1);
        let head = [self.number.to_ne_bytes(), verb.to_ne_bytes()];
        self.end.send([head.as_flattened(), body], file).map_err(|_| NotDone::Lost)?;
        let (count, file) = self.end.receive(&mut self.room).map_err(|_| NotDone::Lost)?;
        let (head, body) = self.room[..count].split_at_checked(HEAD).ok_or(NotDone::Lost)?;
        let (words, _) = head.as_chunks();
        match [words[0], words[1]].map(u32::from_ne_bytes) {
            [number, _] if number != self.number => Err(NotDone::Lost),
            [_, DONE] => Ok(Reply { body, file }),
            _ => Err(NotDone::Refused(body)),
        }
    }

    /// Asks what takes a number at most, and returns `u64` and `u32` at most: on a slate where both
    /// ends are awake, else by message.
    ///
    /// # Errors
    /// It was not done.
    pub fn ask_short(
        &mut self,
        verb: u32,
        argument: Option<u64>,
    ) -> Result<Reply<'_>, NotDone<'_>> {
        if !self.has_asked {
            self.has_asked = true;
            self.slate = self.open_slate()?;
        }
        let number = self.number.wrapping_add(1);
        let asked = Asked { number, verb, argument: argument.unwrap_or(0) };
        let replied =
            self.slate.as_ref().map_or(Replied::Unasked, |slate| self.end.ask(slate, asked));
        match replied {
            Replied::Unasked => {
                let body = argument.map(u64::to_ne_bytes);
                self.ask(verb, body.as_slice().as_flattened(), None)
            }
            Replied::Answer(Answer { status: DONE, first, second }) => {
                self.number = number;
                self.room[..8].copy_from_slice(&first.to_ne_bytes());
                self.room[8..12].copy_from_slice(&second.to_ne_bytes());
                Ok(Reply { body: &self.room[..12], file: None })
            }
            Replied::Answer(_) | Replied::Late => {
                self.number = number;
                self.ask(TELL, &number.to_ne_bytes(), None)
            }
        }
    }

    fn open_slate(&mut self) -> Result<Option<Slate>, NotDone<'static>> {
        match self.ask(SLATE, &[], None) {
            Ok(Reply { file: Some(file), .. }) => {
                Slate::of(file).map(Some).map_err(|_| NotDone::Lost)
            }
            Err(NotDone::Lost) => Err(NotDone::Lost),
            Ok(_) | Err(NotDone::Refused(_)) => Ok(None),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::os::fd::AsFd as _;
    use std::thread::{self, JoinHandle};
    use std::time::Duration;

    use rustix::net::{AddressFamily, SocketFlags, SocketType, socketpair};

    use crate::end::Heard;

    use super::*;

    const STEP: u32 = 1;
    const REFUSED: u32 = 1;

    /// An end that asks, and one in a thread that answers: it returns what it was asked by message and
    /// on the slate. A step returns its argument and 5; one by 0 is refused there and told by message.
    fn pair(awake: Duration, has_slate: bool) -> (Caller, JoinHandle<(Vec<u32>, u32)>) {
        let flags = SocketFlags::CLOEXEC;
        let pair = socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None).unwrap();
        let mut caller = Caller::new(Arc::new(pair.0));
        (caller.end.looks, caller.end.awake) = (true, awake);
        let answering = thread::spawn(move || {
            let mut end = End::new(Arc::new(pair.1));
            (end.looks, end.awake) = (true, Duration::MAX);
            let (slate, file) = Slate::new().unwrap();
            slate.look(true);
            let (mut messages, mut short) = (Vec::new(), 0);
            let mut room = [0; 64];
            loop {
                let message = match end.hear(&mut room, &slate).unwrap() {
                    Heard::Asked(Asked { number, argument, .. }) => {
                        short += 1;
                        let status = if argument == 0 { REFUSED } else { DONE };
                        slate.answer(number, Answer { status, first: argument, second: 5 });
                        continue;
                    }
                    Heard::Message(0, _) => return (messages, short),
                    Heard::Message(count, _) => &room[..count],
                };
                let number = &message[..4];
                let verb = u32::from_ne_bytes(message[4..8].try_into().unwrap());
                messages.push(verb);
                let (status, file) = match verb {
                    SLATE if has_slate => (DONE, Some(file.as_fd())),
                    STEP => (DONE, None),
                    _ => (REFUSED, None),
                };
                let head = [number, &status.to_ne_bytes()].concat();
                let body = [&message[8..], &5_u32.to_ne_bytes()].concat();
                end.send([&head, &body], file).unwrap();
            }
        });
        (caller, answering)
    }

    /// Asks for a step: what it returns, if it is not refused.
    fn step(caller: &mut Caller, argument: u64) -> Option<(u64, u32)> {
        let reply = caller.ask_short(STEP, Some(argument));
        let reply = match reply {
            Err(NotDone::Refused(_)) => return None,
            done => done.unwrap(),
        };
        Some((reply.u64(0).unwrap(), reply.u32(8).unwrap()))
    }

    #[test]
    fn two_ends_that_are_awake_need_one_message_and_one_more_for_a_refusal() {
        let (mut caller, answering) = pair(Duration::MAX, true);
        for argument in [1, 2, u64::MAX] {
            assert_eq!(step(&mut caller, argument), Some((argument, 5)));
        }
        assert_eq!(step(&mut caller, 0), None);
        assert_eq!(step(&mut caller, 3), Some((3, 5)));
        drop(caller);
        assert_eq!(answering.join().unwrap(), (vec![SLATE, TELL], 5));
    }

    #[test]
    fn without_a_slate_and_where_this_end_sleeps_all_goes_by_message() {
        for (looks, has_slate) in [(true, false), (false, true)] {
            let (mut caller, answering) = pair(Duration::MAX, has_slate);
            // The slate is opened first, by message.
            assert_eq!(step(&mut caller, 1), Some((1, 5)));
            caller.end.looks = looks;
            assert_eq!(step(&mut caller, 2), Some((2, 5)));
            drop(caller);
            let (messages, short) = answering.join().unwrap();
            assert_eq!((&messages[..1], messages.last()), (&[SLATE][..], Some(&STEP)));
            assert_eq!((messages.len() as u32) + short, 3);
        }
    }
}
