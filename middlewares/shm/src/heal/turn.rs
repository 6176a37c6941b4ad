//! Mutual exclusion between healing passes and the creation of nodes.

use std::fs::File;
use std::io;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock};

/// How long to wait for another process's turn, so that a stopped process does not block all
/// others.
const PATIENCE: Duration = Duration::from_millis(500);

/// Interval between attempts to get the lock.
const TICK: Duration = Duration::from_millis(1);

/// The locked folder of iceoryx2's files. The lock ends with the process.
#[derive(Debug)]
pub(crate) struct Turn {
    _folder: File,
}

impl Turn {
    /// Waits for the lock for a limited time, then goes on without it: concurrent passes do no
    /// harm, they only duplicate work.
    pub(crate) fn take(root: &Path) -> io::Result<Self> {
        let folder = File::open(root)?;
        let end = Instant::now() + PATIENCE;
        while flock(&folder, FlockOperation::NonBlockingLockExclusive).is_err() {
            if Instant::now() > end {
                tracing::warn!(root = %root.display(), "another process holds the folder of iceoryx2: going on without it");
                break;
            }
            thread::park_timeout(TICK);
        }
        Ok(Self { _folder: folder })
    }
}
