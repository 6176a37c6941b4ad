//! Memory of a port, which the program maps: a file that nobody else can open, of a size that nobody
//! can change.
//!
//! It begins with `u64` how often the value was written (by the program to an in port, by codels to an
//! out port) and `u32` whether the port is gone; the value is at [`VALUE_AT`], in C layout. The daemon
//! reads and writes the file rather than mapping it: whatever the program does there meanwhile, it gets
//! bytes that it checks.

use std::fs::File;
use std::io::{self, IoSlice, IoSliceMut};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::FileExt as _;

use genom_lockstep::{checked, sealed};
use rustix::io::{preadv, pwritev};

/// Where the value is. A multiple of every alignment.
pub(crate) const VALUE_AT: u64 = 64;

/// Where it is said that the port is gone.
const GONE_AT: u64 = 8;

/// The largest value that is read to know whether it was written, in bytes: to read it takes less time
/// than to ask the system once more.
const AT_ONCE: usize = 4096;

/// Name of the file, as `/proc/PID/maps` shows it.
const NAME: &str = "genom-port";

#[derive(Debug)]
pub(crate) struct Memory {
    file: File,
}

impl Memory {
    /// Memory for a value of so many bytes, all zero.
    pub(crate) fn new(size: usize) -> io::Result<Self> {
        Ok(Self { file: sealed(NAME, VALUE_AT + size as u64)? })
    }

    /// Memory that another process made for a value of so many bytes. It may be mapped only if nobody
    /// can change its size, which would end whoever looks there then.
    pub(crate) fn of(file: OwnedFd, size: usize) -> io::Result<Self> {
        Ok(Self { file: checked(file, VALUE_AT + size as u64)? })
    }

    /// How often the value was written.
    pub(crate) fn written(&self) -> io::Result<u64> {
        let mut count = [0; 8];
        self.file.read_exact_at(&mut count, 0)?;
        Ok(u64::from_ne_bytes(count))
    }

    /// Gets the value, unless its count is this one; returns its count. A small value takes one call
    /// of the system, which each step makes for each in port.
    pub(crate) fn read_new(&self, known: u64, value: &mut [u8]) -> io::Result<Option<u64>> {
        if value.len() > AT_ONCE && self.written()? == known {
            return Ok(None);
        }
        let (mut count, mut rest) = ([0; 8], [0; VALUE_AT as usize - 8]);
        let whole = count.len() + rest.len() + value.len();
        let parts = [&mut count[..], &mut rest, value];
        if preadv(&self.file, &mut parts.map(IoSliceMut::new), 0)? != whole {
            // Its size stays: the system has stopped in the middle of a large value.
            self.file.read_exact_at(value, VALUE_AT)?;
        }
        let count = u64::from_ne_bytes(count);
        Ok((count != known).then_some(count))
    }

    /// Sets the value.
    pub(crate) fn write(&self, value: &[u8]) -> io::Result<()> {
        self.file.write_all_at(value, VALUE_AT)
    }

    /// Sets the value, and how often it was written, of a port that is there: a small value takes one
    /// call of the system, which each step makes for each out port that was written.
    pub(crate) fn show(&self, value: &[u8], count: u64) -> io::Result<()> {
        let head = [0; VALUE_AT as usize - 8];
        let parts = [&count.to_ne_bytes()[..], &head, value];
        let whole = VALUE_AT as usize + value.len();
        if pwritev(&self.file, &parts.map(IoSlice::new), 0)? != whole {
            // Its size stays: the system has stopped in the middle of a large value.
            self.write(value)?;
        }
        Ok(())
    }

    /// Whether it is said that the port is gone.
    pub(crate) fn is_gone(&self) -> io::Result<bool> {
        let mut gone = [0; 4];
        self.file.read_exact_at(&mut gone, GONE_AT)?;
        Ok(u32::from_ne_bytes(gone) != 0)
    }

    /// Says whether the port is gone.
    pub(crate) fn set_gone(&self, gone: bool) -> io::Result<()> {
        self.file.write_all_at(&u32::from(gone).to_ne_bytes(), GONE_AT)
    }
}

impl AsFd for Memory {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_one_end_writes_the_other_reads_and_none_changes_the_size() {
        let memory = Memory::new(4).unwrap();
        let theirs = File::from(memory.as_fd().try_clone_to_owned().unwrap());
        theirs.write_all_at(&3_u64.to_ne_bytes(), 0).unwrap();
        theirs.write_all_at(b"abcd", VALUE_AT).unwrap();
        let mut value = [0; 4];
        assert_eq!(memory.read_new(2, &mut value).unwrap(), Some(3));
        assert_eq!((memory.written().unwrap(), &value), (3, b"abcd"));
        assert_eq!(memory.read_new(3, &mut value).unwrap(), None);
        memory.show(b"efgh", 4).unwrap();
        let mut whole = [0; VALUE_AT as usize + 4];
        theirs.read_exact_at(&mut whole, 0).unwrap();
        assert_eq!(whole[..8], 4_u64.to_ne_bytes());
        assert_eq!((&whole[8..64], &whole[64..]), (&[0; 56][..], &b"efgh"[..]));
        assert!(theirs.set_len(1).is_err() && theirs.set_len(4096).is_err());
        assert!(!memory.is_gone().unwrap());
        memory.set_gone(true).unwrap();
        assert!(Memory::of(theirs.try_clone().unwrap().into(), 5).is_err());
        assert!(Memory::of(theirs.into(), 4).unwrap().is_gone().unwrap());
    }
}
