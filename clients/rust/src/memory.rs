//! Memory of a port, which the daemon has, too.
//!
//! `daemon/embedding/src/memory.rs` documents it. The daemon writes it only while it answers a step,
//! and this program writes values of in ports only, which the daemon reads as a file.

use std::io;
use std::os::fd::OwnedFd;
use std::slice;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

use memmap2::{MmapOptions, MmapRaw};

/// Where the value is. A multiple of every alignment.
pub(crate) const VALUE_AT: usize = 64;

/// Where it is said that the port is gone.
const GONE_AT: usize = 8;

#[derive(Debug)]
pub(crate) struct Memory {
    map: MmapRaw,
    size: usize,
}

impl Memory {
    /// Maps a file with a value of so many bytes.
    pub(crate) fn new(file: OwnedFd, size: usize) -> io::Result<Self> {
        let file = std::fs::File::from(file);
        let whole = VALUE_AT.checked_add(size).ok_or(io::ErrorKind::InvalidData)?;
        // Its size is sealed: pages that are there now stay.
        if file.metadata()?.len() < whole as u64 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        Ok(Self { map: MmapOptions::new().len(whole).map_raw(&file)?, size })
    }

    /// Bytes of the value.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    pub(crate) fn value(&self) -> *mut u8 {
        // SAFETY: the map is of VALUE_AT bytes and the value.
        unsafe { self.map.as_mut_ptr().add(VALUE_AT) }
    }

    /// The value.
    ///
    /// # Safety
    /// Nothing writes it while the slice is there: the daemon answers no step, and there is no other
    /// slice of [`bytes_mut`](Self::bytes_mut).
    pub(crate) unsafe fn bytes(&self) -> &[u8] {
        // SAFETY: the map is of VALUE_AT bytes and the value; the caller excludes writers.
        unsafe { slice::from_raw_parts(self.value(), self.size) }
    }

    /// The value of an in port, to be changed. The daemon never writes it.
    pub(crate) fn bytes_mut(&mut self) -> &mut [u8] {
        // SAFETY: the map is of VALUE_AT bytes and the value, and borrowed by this slice alone; the
        // daemon only reads, with system calls.
        unsafe { slice::from_raw_parts_mut(self.value(), self.size) }
    }

    pub(crate) fn written(&self) -> u64 {
        self.count().load(Ordering::Relaxed)
    }

    /// Counts a value that was written here. The message of the next step orders the two.
    pub(crate) fn wrote(&self) {
        self.count().fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn is_gone(&self) -> bool {
        // SAFETY: GONE_AT is a multiple of four below VALUE_AT, and the start of a map is aligned; it
        // is only used as an atomic here.
        let gone = unsafe { AtomicU32::from_ptr(self.map.as_mut_ptr().add(GONE_AT).cast()) };
        gone.load(Ordering::Relaxed) != 0
    }

    fn count(&self) -> &AtomicU64 {
        // SAFETY: the start of a map is aligned, and this is only used as an atomic here.
        unsafe { AtomicU64::from_ptr(self.map.as_mut_ptr().cast()) }
    }
}
