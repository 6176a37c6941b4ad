//! Reserves disk space before it is written, so that a recording on a full disk ends with its index
//! instead of in the middle of a sample.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use rustix::fs::{FallocateFlags, fallocate};
use rustix::io::Errno;
use rustix::process::{Resource, getrlimit};

/// Bytes reserved at once.
const STEP: u64 = 4 << 20;

/// Disk space reserved for one file.
#[derive(Debug)]
pub(crate) struct Room {
    file: File,
    /// Size of the reserved space, from the beginning of the file.
    ours: u64,
    /// Whether the file system can reserve space. If not, writing fails when the disk is full.
    promised: bool,
    /// Bytes that the file may have.
    most: u64,
}

impl Room {
    /// For this file.
    pub(crate) fn of(file: &File) -> io::Result<Self> {
        Ok(Self { file: file.try_clone()?, ours: 0, promised: true, most: u64::MAX })
    }

    /// Sets how many bytes the file may have.
    pub(crate) fn limit(&mut self, most: u64) {
        self.most = most;
    }

    /// Reserves space up to `end` bytes.
    ///
    /// # Errors
    /// There is not enough space; the same error as writing would give.
    pub(crate) fn reach(&mut self, end: u64) -> io::Result<()> {
        if end > self.most {
            return Err(io::Error::other("the limit of bytes is reached"));
        }
        if getrlimit(Resource::Fsize).current.is_some_and(|most| end > most) {
            return Err(Errno::FBIG.into());
        }
        if !self.promised || end <= self.ours {
            return Ok(());
        }
        // `KEEP_SIZE`: the size of the file stays what was written, and unused space is released at
        // the end.
        let ask = |to: u64| {
            fallocate(&self.file, FallocateFlags::KEEP_SIZE, self.ours, to - self.ours).map(|()| to)
        };
        match ask(end.saturating_add(STEP)).or_else(|_| ask(end)) {
            Ok(to) => self.ours = to,
            Err(full @ (Errno::NOSPC | Errno::DQUOT | Errno::FBIG)) => return Err(full.into()),
            Err(_) => self.promised = false,
        }
        Ok(())
    }

    /// Releases unused space.
    pub(crate) fn done(self) -> io::Result<()> {
        let size = self.file.metadata()?.len();
        self.file.set_len(size)
    }
}

/// A writer whose position others can read.
#[derive(Debug)]
pub(crate) struct Counted<W> {
    inner: W,
    at: u64,
    end: Arc<AtomicU64>,
}

impl<W> Counted<W> {
    /// Counts the bytes written to `inner`, from 0.
    pub(crate) fn new(inner: W) -> (Self, Arc<AtomicU64>) {
        let end = Arc::<AtomicU64>::default();
        (Self { inner, at: 0, end: Arc::clone(&end) }, end)
    }
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.at += written as u64;
        self.end.fetch_max(self.at, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<W: Seek> Seek for Counted<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.at = self.inner.seek(to)?;
        Ok(self.at)
    }

    fn stream_position(&mut self) -> io::Result<u64> {
        // Known without asking the buffered writer.
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_asked_for_ahead_and_what_is_not_used_is_given_back() {
        use std::os::unix::fs::MetadataExt as _;
        let file = tempfile::tempfile().unwrap();
        let mut room = Room::of(&file).unwrap();
        room.reach(1000).unwrap();
        assert_eq!(file.metadata().unwrap().len(), 0);
        if room.promised {
            assert!(file.metadata().unwrap().blocks() * 512 >= 1000);
        }
        room.done().unwrap();
        assert_eq!(file.metadata().unwrap().blocks(), 0);
    }

    #[test]
    fn a_disk_that_promises_nothing_is_written_to_all_the_same() {
        let file = File::options().write(true).open("/dev/null").unwrap();
        let mut room = Room::of(&file).unwrap();
        room.reach(1 << 40).unwrap();
        assert!(!room.promised);
    }

    #[test]
    fn the_end_is_counted_also_when_the_writer_goes_back() {
        let (mut counted, end) = Counted::new(std::io::Cursor::new(Vec::new()));
        counted.write_all(b"0123456789").unwrap();
        counted.seek(SeekFrom::Start(2)).unwrap();
        counted.write_all(b"ab").unwrap();
        assert_eq!((end.load(Ordering::Relaxed), counted.stream_position().unwrap()), (10, 4));
        counted.flush().unwrap();
        assert_eq!(counted.inner.into_inner(), b"01ab456789");
    }
}
