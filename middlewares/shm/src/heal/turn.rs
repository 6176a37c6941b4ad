//! Passes and starts of nodes take turns.

use std::fs::File;
use std::io;
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use rustix::fs::{FlockOperation, flock};

/// How long another's turn is waited for: one that is stopped must not stop everybody.
const PATIENCE: Duration = Duration::from_millis(500);

/// Tells threads to look again.
const TICK: Duration = Duration::from_millis(1);

/// The folder of iceoryx2's files, locked. The lock is the process's: it ends with it.
#[derive(Debug)]
pub(crate) struct Turn {
    _folder: File,
}

impl Turn {
    /// Waits for its turn, within bounds: passes do no harm to each other, they only do twice
    /// what one would do.
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
