//! What all files of recordings need: their ending, limits, locks, and what is a file.

use std::fs;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What names of files end with.
pub(super) const ENDING: &str = ".mcap";
/// Recordings, and replays, under way at once.
pub(super) const AT_ONCE: usize = 4;

/// Whether it is a file, and no link to one.
pub(super) fn is_file(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file())
}

/// Whether it is a link, wherever that leads.
pub(super) fn is_link(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_symlink())
}

/// What a thread that failed meanwhile left is whole: each change is one assignment.
pub(super) fn lock<T>(what: &Mutex<T>) -> MutexGuard<'_, T> {
    what.lock().unwrap_or_else(PoisonError::into_inner)
}
