//! The file that holds a memory: anonymous, of a size that nobody can change.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::fs::FileExt as _;

use rustix::fs::{
    MemfdFlags, SealFlags, fcntl_add_seals, fcntl_get_seals, ftruncate, memfd_create,
};
use rustix::io::Errno;

use crate::layout::{Layout, MAGIC};

/// Memory that belongs to no process, but to all that hold it open.
#[derive(Debug)]
pub struct Memory {
    pub(crate) file: File,
    pub(crate) layout: Layout,
}

/// It is no memory of a black box.
#[derive(Debug, thiserror::Error)]
pub enum MemoryError {
    /// The system refuses.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// Its size could change, or its content is something else.
    #[error("it is no memory of a black box")]
    Other,
}

/// Name of the file, as `/proc/PID/fd` and `/proc/PID/maps` show it.
const NAME: &str = "genom-blackbox";

impl Memory {
    /// Makes one with this many bytes for records (from [`LEAST_BYTES`](crate::LEAST_BYTES) to
    /// [`MOST_BYTES`](crate::MOST_BYTES)). It takes memory only as far as it is written to.
    ///
    /// # Errors
    /// The system refuses.
    pub fn new(bytes: u64) -> io::Result<Self> {
        let layout = Layout::of_bytes(bytes);
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        // Nothing in it is to be executed; kernels before 6.3 cannot be told so.
        let file = match memfd_create(NAME, flags | MemfdFlags::NOEXEC_SEAL) {
            Err(Errno::INVAL) => memfd_create(NAME, flags)?,
            made => made?,
        };
        ftruncate(&file, layout.size() as u64)?;
        let file = File::from(file);
        file.write_all_at(&MAGIC.to_le_bytes(), 0)?;
        file.write_all_at(&(layout.blocks as u64).to_le_bytes(), 8)?;
        fcntl_add_seals(&file, SealFlags::SHRINK | SealFlags::GROW | SealFlags::SEAL)?;
        Ok(Self { file, layout })
    }

    /// One that another process made.
    ///
    /// # Errors
    /// It is none.
    pub fn of(file: OwnedFd) -> Result<Self, MemoryError> {
        let seals = fcntl_get_seals(&file).map_err(|_| MemoryError::Other)?;
        if !seals.contains(SealFlags::SHRINK | SealFlags::GROW) {
            return Err(MemoryError::Other);
        }
        let file = File::from(file);
        let layout = Layout::of_size(file.metadata()?.len()).ok_or(MemoryError::Other)?;
        let mut start = [0; 8];
        file.read_exact_at(&mut start, 0)?;
        if u64::from_le_bytes(start) != MAGIC {
            return Err(MemoryError::Other);
        }
        Ok(Self { file, layout })
    }

    /// The one that a process has open, for a daemon that did not start it.
    ///
    /// # Errors
    /// It has none, or the system does not let this process look.
    pub fn of_process(pid: u32) -> Result<Self, MemoryError> {
        for entry in std::fs::read_dir(format!("/proc/{pid}/fd"))? {
            let path = entry?.path();
            let name = std::fs::read_link(&path).unwrap_or_default();
            if name.to_str().is_some_and(|name| name.starts_with(&format!("/memfd:{NAME} "))) {
                return Self::of(File::options().read(true).open(path)?.into());
            }
        }
        Err(MemoryError::Other)
    }

    /// Bytes for records.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        (self.layout.blocks * crate::layout::BLOCK) as u64
    }

    /// Bytes of memory that it takes now.
    ///
    /// # Errors
    /// The system refuses.
    pub fn taken(&self) -> io::Result<u64> {
        use std::os::unix::fs::MetadataExt as _;
        Ok(self.file.metadata()?.blocks() * 512)
    }
}

impl AsFd for Memory {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.file.as_fd()
    }
}
