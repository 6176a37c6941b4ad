//! A cell of this daemon, which it steps over a socket that it lent the cell's process: the cell
//! answers it as a daemon answers its program. What a cell answers is checked.

use std::os::fd::{AsFd as _, BorrowedFd, OwnedFd};
use std::sync::Arc;

use axum::http::StatusCode;
use genom_doors::RpcError;
use genom_lockstep::{Caller, NotDone, Reply};
use genom_protocol::{Address, Refusal};
use rustix::event::{PollFd, PollFlags, Timespec, poll};

use crate::memory::Memory;
use crate::port::{LARGEST, no_memory};
use crate::wire::{Opened, Taken, Verb};

/// One process of a cell.
#[derive(Debug)]
pub(crate) struct Far {
    /// Of the cell.
    pub(crate) name: String,
    caller: Caller,
    /// How many of its ports were not there after the last step.
    pub(crate) gone: u32,
}

/// Why a cell did not do what it was asked.
#[derive(Debug)]
pub(crate) enum Undone {
    /// Its process ended, or answers what is no answer.
    Lost,
    /// It refused.
    Refused(RpcError),
}

/// A port that a cell has opened.
#[derive(Debug)]
pub(crate) struct Found {
    /// Its number in the cell.
    pub(crate) number: u32,
    pub(crate) is_in: bool,
    pub(crate) size: usize,
    pub(crate) digest: String,
}

impl Far {
    pub(crate) fn new(name: &str, socket: Arc<OwnedFd>) -> Self {
        Self { name: name.to_owned(), caller: Caller::new(socket), gone: 0 }
    }

    /// Whether it is this process.
    pub(crate) fn is(&self, socket: &Arc<OwnedFd>) -> bool {
        Arc::ptr_eq(self.caller.socket(), socket)
    }

    pub(crate) fn socket(&self) -> &Arc<OwnedFd> {
        self.caller.socket()
    }

    /// Advances its clock.
    pub(crate) fn step(&mut self, nanoseconds: u64) -> Result<(), Undone> {
        let reply = self.caller.ask_short(Verb::Step as u32, Some(nanoseconds))?;
        self.gone = reply.u32(8).ok_or(Undone::Lost)?;
        Ok(())
    }

    /// Has it publish what was written to its in ports.
    pub(crate) fn publish(&mut self) -> Result<(), Undone> {
        self.caller.ask_short(Verb::Publish as u32, None)?;
        Ok(())
    }

    /// Opens a port; its memory is new.
    pub(crate) fn open(&mut self, address: &Address) -> Result<(Found, Memory), Undone> {
        let reply = self.ask(Verb::Open, address.to_string().as_bytes(), None)?;
        let found = found(reply.body)?;
        let memory = reply.file.map(|file| Memory::of(file, found.size));
        match memory {
            Some(Ok(memory)) => Ok((found, memory)),
            Some(Err(error)) => Err(Undone::Refused(no_memory(address, &error))),
            None => Err(Undone::Lost),
        }
    }

    /// Gives it the memory of a port.
    pub(crate) fn take(&mut self, taken: &Taken<'_>, memory: &Memory) -> Result<Found, Undone> {
        let reply = self.ask(Verb::Take, &taken.bytes(), Some(memory.as_fd()))?;
        found(reply.body)
    }

    /// Has it forget a port.
    pub(crate) fn close(&mut self, number: u32) {
        // One that has ended has forgotten it.
        let _ = self.ask(Verb::Close, &number.to_ne_bytes(), None);
    }

    /// Asks, and waits for the answer: as long as its codels take.
    fn ask(
        &mut self,
        verb: Verb,
        body: &[u8],
        file: Option<BorrowedFd<'_>>,
    ) -> Result<Reply<'_>, Undone> {
        Ok(self.caller.ask(verb as u32, body, file)?)
    }
}

impl From<NotDone<'_>> for Undone {
    fn from(not: NotDone<'_>) -> Self {
        match not {
            NotDone::Lost => Self::Lost,
            NotDone::Refused(why) => Self::Refused(refused(why)),
        }
    }
}

/// Whether the process at the other end has ended.
pub(crate) fn is_closed(socket: &OwnedFd) -> bool {
    let mut end = [PollFd::new(socket, PollFlags::empty())];
    let at_once = Timespec { tv_sec: 0, tv_nsec: 0 };
    poll(&mut end, Some(&at_once)).is_ok_and(|count| count > 0)
}

fn found(body: &[u8]) -> Result<Found, Undone> {
    let opened = Opened::read(body).ok_or(Undone::Lost)?;
    let size = usize::try_from(opened.size).ok().filter(|size| *size <= LARGEST);
    let size = size.ok_or(Undone::Lost)?;
    let Opened { number, is_in, digest, .. } = opened;
    Ok(Found { number, is_in, size, digest: digest.to_owned() })
}

/// What a cell refused, as it says it.
fn refused(why: &[u8]) -> RpcError {
    match serde_json::from_slice::<Refusal>(why) {
        Ok(refusal) => RpcError::passed_on(StatusCode::CONFLICT, refusal.error),
        Err(error) => RpcError::internal(format!("what a cell refuses cannot be read: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use genom_lockstep::{DONE, End};
    use rustix::fs::{MemfdFlags, ftruncate, memfd_create};
    use rustix::net::{AddressFamily, SocketFlags, SocketType, socketpair};

    use crate::memory::VALUE_AT;
    use crate::wire::{self, LONGEST};

    use super::*;

    /// Opens a port of a cell that answers with these bytes, after the number of the request if they
    /// are to have it, and this file.
    fn opened(with_number: bool, reply: &[u8], file: Option<OwnedFd>) -> Result<(), Undone> {
        let flags = SocketFlags::CLOEXEC;
        let pair = socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None).unwrap();
        let (ours, theirs) = pair;
        let mut reply = reply.to_vec();
        let cell = thread::spawn(move || {
            let mut message = [0; LONGEST];
            let mut theirs = End::new(Arc::new(theirs));
            let (count, none) = theirs.receive(&mut message).unwrap();
            assert!(none.is_none());
            let (number, asked) = wire::parse(&message[..count]);
            assert_eq!(asked, Ok(wire::Request::Open("demo/gain")));
            if with_number {
                reply.splice(0..0, number.to_ne_bytes());
            }
            theirs.send([&reply, &[]], file.as_ref().map(|file| file.as_fd())).unwrap();
        });
        let mut far = Far::new("arm", Arc::new(ours));
        let done = far.open(&"demo/gain".parse().unwrap()).map(drop);
        cell.join().unwrap();
        done
    }

    /// A reply about a port whose values have so many bytes.
    fn told(size: u64) -> Vec<u8> {
        let opened = Opened { number: 1, is_in: true, size, digest: "ab" };
        [DONE.to_ne_bytes().to_vec(), opened.bytes()].concat()
    }

    fn plain_file(size: u64) -> OwnedFd {
        let file = memfd_create("other", MemfdFlags::ALLOW_SEALING).unwrap();
        ftruncate(&file, VALUE_AT + size).unwrap();
        file
    }

    #[test]
    fn a_port_of_a_cell_comes_with_memory_whose_size_stays() {
        let memory = |size| Some(Memory::new(size).unwrap().as_fd().try_clone_to_owned().unwrap());
        opened(true, &told(8), memory(8)).unwrap();
        for file in [memory(4), Some(plain_file(8)), Some(std::io::pipe().unwrap().0.into())] {
            let refused = opened(true, &told(8), file).unwrap_err();
            let Undone::Refused(error) = refused else { panic!("{refused:?}") };
            assert!(error.message().contains("demo/gain"), "{}", error.message());
        }
        assert!(matches!(opened(true, &told(8), None), Err(Undone::Lost)));
    }

    #[test]
    fn what_a_cell_answers_that_is_no_answer_is_none() {
        let word = |word: u32| word.to_ne_bytes().to_vec();
        let too_large = told(LARGEST as u64 + 1);
        let cut = told(8)[..12].to_vec();
        let many = vec![0; 60_000];
        for reply in [Vec::new(), vec![0; 3], too_large, cut, told(u64::MAX)] {
            assert!(matches!(opened(true, &reply, None), Err(Undone::Lost)), "{reply:?}");
        }
        // As of another request, and nothing at all.
        assert!(matches!(opened(false, &many, None), Err(Undone::Lost)));
        assert!(matches!(opened(false, &[], None), Err(Undone::Lost)));
        for why in [&b"{"[..], b"\xff", &many] {
            let reply = [word(1), why.to_vec()].concat();
            let refused = opened(true, &reply, None);
            assert!(matches!(refused, Err(Undone::Refused(_))), "{refused:?}");
        }
    }

    #[test]
    fn the_end_of_a_process_is_seen_at_its_socket() {
        let flags = SocketFlags::CLOEXEC;
        let pair = socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, flags, None).unwrap();
        let (ours, theirs) = pair;
        assert!(!is_closed(&ours));
        drop(theirs);
        assert!(is_closed(&ours));
        let mut far = Far::new("arm", Arc::new(ours));
        assert!(matches!(far.step(1), Err(Undone::Lost)));
    }
}
