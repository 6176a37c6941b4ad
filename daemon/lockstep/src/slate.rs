//! Memory that both ends of a pair have: one writes a request there, the other its answer. While both
//! are awake this takes no call of the system, so that a step costs neither of them a message.
//!
//! | at | by whom | what |
//! |---|---|---|
//! | 0 | who asks | `u32` number of the request, written last |
//! | 4 | | `u32` verb |
//! | 8 | | `u64` argument |
//! | 64 | who answers | `u32` number of the request that was answered last, written last |
//! | 68 | | `u32` status: 0 done, else there is more to tell than has room here |
//! | 72 | | `u64` first result |
//! | 80 | | `u32` second result |
//! | 128 | who answers | `u32` 1 while it looks for requests here |
//!
//! Each of the three parts has a cache line of its own. That the other end looks is a hint only: it may
//! fall asleep at the same moment. Who gets no answer for [`AWAKE`](crate::AWAKE) therefore sends a
//! message, which wakes it, and hears the answer that way. Whatever the other end writes here, it is
//! read as numbers.

#![allow(unsafe_code)]

use std::fs::File;
use std::io;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use memmap2::{MmapOptions, MmapRaw};

use crate::sealed::{checked, sealed};

/// Bytes of the memory.
const SIZE: usize = 192;

/// Places in it.
const ASKED: usize = 0;
const VERB: usize = 4;
const ARGUMENT: usize = 8;
const ANSWERED: usize = 64;
const STATUS: usize = 68;
const FIRST: usize = 72;
const SECOND: usize = 80;
const LOOKS: usize = 128;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Asked {
    /// The number of the request.
    pub number: u32,
    /// What to do.
    pub verb: u32,
    /// With what.
    pub argument: u64,
}

/// What is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// 0 if it was done.
    pub status: u32,
    /// What it returns.
    pub first: u64,
    /// And what else.
    pub second: u32,
}

/// The memory.
#[derive(Debug)]
pub struct Slate {
    map: MmapRaw,
}

impl Slate {
    /// Makes one; returns the file, for the other end.
    ///
    /// # Errors
    /// There is no memory, or no descriptor, left.
    pub fn new() -> io::Result<(Self, File)> {
        let file = sealed("genom-slate", SIZE as u64)?;
        Ok((Self::map(&file)?, file))
    }

    /// Takes the one that the other end has made.
    ///
    /// # Errors
    /// It is none.
    pub fn of(file: OwnedFd) -> io::Result<Self> {
        Self::map(&checked(file, SIZE as u64)?)
    }

    /// Its size is sealed: pages that are there now stay. The file is not needed any more.
    fn map(file: &File) -> io::Result<Self> {
        Ok(Self { map: MmapOptions::new().len(SIZE).map_raw(file)? })
    }

    /// Whether the other end seems to look for requests here.
    #[must_use]
    pub fn is_looked_at(&self) -> bool {
        self.word(LOOKS).load(Ordering::Relaxed) == 1
    }

    /// Asks. The last request has to be answered.
    pub fn ask(&self, asked: Asked) {
        self.word(VERB).store(asked.verb, Ordering::Relaxed);
        self.long(ARGUMENT).store(asked.argument, Ordering::Relaxed);
        self.word(ASKED).store(asked.number, Ordering::Release);
    }

    /// The answer to the request of this number, if it is there.
    #[must_use]
    pub fn answer_to(&self, number: u32) -> Option<Answer> {
        if self.word(ANSWERED).load(Ordering::Acquire) != number {
            return None;
        }
        let status = self.word(STATUS).load(Ordering::Relaxed);
        let first = self.long(FIRST).load(Ordering::Relaxed);
        Some(Answer { status, first, second: self.word(SECOND).load(Ordering::Relaxed) })
    }

    /// Tells the other end whether this one looks for requests here.
    pub fn look(&self, looks: bool) {
        self.word(LOOKS).store(u32::from(looks), Ordering::Relaxed);
    }

    /// The request that was not answered yet.
    #[must_use]
    pub fn asked(&self) -> Option<Asked> {
        let number = self.word(ASKED).load(Ordering::Acquire);
        if number == self.word(ANSWERED).load(Ordering::Relaxed) {
            return None;
        }
        let verb = self.word(VERB).load(Ordering::Relaxed);
        Some(Asked { number, verb, argument: self.long(ARGUMENT).load(Ordering::Relaxed) })
    }

    /// Answers the request of this number.
    pub fn answer(&self, number: u32, answer: Answer) {
        self.word(STATUS).store(answer.status, Ordering::Relaxed);
        self.long(FIRST).store(answer.first, Ordering::Relaxed);
        self.word(SECOND).store(answer.second, Ordering::Relaxed);
        self.word(ANSWERED).store(number, Ordering::Release);
    }

    fn word(&self, at: usize) -> &AtomicU32 {
        debug_assert!(at.is_multiple_of(4) && at + 4 <= SIZE);
        // SAFETY: the map has SIZE bytes and begins at a page; each place is below it and a multiple of
        // its size, and this process uses the places as atomics only.
        unsafe { AtomicU32::from_ptr(self.map.as_mut_ptr().add(at).cast()) }
    }

    fn long(&self, at: usize) -> &AtomicU64 {
        debug_assert!(at.is_multiple_of(8) && at + 8 <= SIZE);
        // SAFETY: as for words.
        unsafe { AtomicU64::from_ptr(self.map.as_mut_ptr().add(at).cast()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair() -> (Slate, Slate) {
        let (ours, file) = Slate::new().unwrap();
        (ours, Slate::of(file.into()).unwrap())
    }

    #[test]
    fn a_request_is_seen_once_and_its_answer_by_its_number() {
        let (asks, answers) = pair();
        assert_eq!((answers.asked(), asks.is_looked_at()), (None, false));
        answers.look(true);
        assert!(asks.is_looked_at());
        let asked = Asked { number: 7, verb: 1, argument: u64::MAX };
        asks.ask(asked);
        assert_eq!((answers.asked(), asks.answer_to(7)), (Some(asked), None));
        let answer = Answer { status: 0, first: 1 << 40, second: 3 };
        answers.answer(7, answer);
        assert_eq!((answers.asked(), asks.answer_to(7)), (None, Some(answer)));
        assert_eq!(asks.answer_to(8), None);
    }

    #[test]
    fn what_is_no_slate_is_refused() {
        assert!(Slate::of(sealed("test", 64).unwrap().into()).is_err());
        assert!(Slate::of(File::open("/dev/null").unwrap().into()).is_err());
    }
}
