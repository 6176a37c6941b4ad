//! The memory as the process that writes has it mapped. The only unsafe module of this crate.
//!
//! Nothing refers to the mapped bytes: they are written through pointers, and words that others
//! read are atomic. The file is sealed against shrinking, so that no access faults for its size.
#![allow(unsafe_code)]

use std::io;
use std::os::fd::AsFd;
use std::ptr::{self, NonNull};
use std::sync::atomic::AtomicU64;

use rustix::mm::{Advice, MapFlags, ProtFlags, madvise, mmap, munmap};

/// A file, mapped.
#[derive(Debug)]
pub(crate) struct Map {
    at: NonNull<u8>,
    size: usize,
}

// SAFETY: the mapping belongs to no thread; bytes are written by the one track that owns their
// block, words are atomic.
unsafe impl Send for Map {}
// SAFETY: as above.
unsafe impl Sync for Map {}

impl Map {
    /// Maps the first `size` bytes of a file, which must not shrink.
    pub(crate) fn new(file: impl AsFd, size: usize) -> io::Result<Self> {
        let rights = ProtFlags::READ | ProtFlags::WRITE;
        // SAFETY: a mapping at an address that the system chooses replaces no other.
        let at = unsafe { mmap(ptr::null_mut(), size, rights, MapFlags::SHARED, file, 0) }?;
        let at = NonNull::new(at.cast()).ok_or(io::ErrorKind::InvalidData)?;
        let map = Self { at, size };
        // Children that codels fork have no part in it. SAFETY: it changes nothing in this process.
        let _ = unsafe { madvise(map.at.as_ptr().cast(), size, Advice::LinuxDontFork) };
        Ok(map)
    }

    /// The word at an offset, a multiple of 8 within the mapping.
    #[inline]
    pub(crate) fn word(&self, at: usize) -> &AtomicU64 {
        assert!(at.is_multiple_of(8) && at <= self.size - 8);
        // SAFETY: within the mapping, which is aligned to pages; all access to words is atomic.
        unsafe { AtomicU64::from_ptr(self.at.add(at).as_ptr().cast()) }
    }

    /// Writes bytes at an offset.
    #[inline]
    pub(crate) fn write(&self, at: usize, bytes: &[u8]) {
        assert!(at <= self.size && bytes.len() <= self.size - at);
        // SAFETY: within the mapping; the caller's bytes are not, since nothing refers to it.
        unsafe { ptr::copy_nonoverlapping(bytes.as_ptr(), self.at.add(at).as_ptr(), bytes.len()) }
    }
}

impl Drop for Map {
    fn drop(&mut self) {
        // SAFETY: mapped in `new`; nothing refers to it any more.
        let _ = unsafe { munmap(self.at.as_ptr().cast(), self.size) };
    }
}
