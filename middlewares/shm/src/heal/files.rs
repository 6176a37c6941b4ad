//! What the name and state of a file say about it.

use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use super::places::Places;

/// Smallest valid identity: the upper half is a process id, which is never zero.
const LEAST: u128 = 1 << 64;

/// The identities in the name of a segment: `PREFIX KIND _ID`, or `_ID_ID` for a connection.
pub(super) fn ids(places: &Places, name: &str) -> impl Iterator<Item = u128> + use<> {
    let stem = name.strip_prefix(places.prefix.as_str()).unwrap_or_default();
    let stem = stem.split('.').next().unwrap_or_default();
    let parts: Vec<u128> = stem.split('_').filter_map(|part| part.parse().ok()).collect();
    parts.into_iter().filter(|id| *id >= LEAST)
}

/// Whether a file was never completed: iceoryx2 sets its size first, and read permission last.
pub(super) fn is_unfinished(file: &Path) -> bool {
    is_unreadable(file) || is_empty(file)
}

/// Whether the owner has no read permission.
pub(super) fn is_unreadable(file: &Path) -> bool {
    const READ: u32 = 0o400;
    fs::symlink_metadata(file).is_ok_and(|told| told.is_file() && told.mode() & READ == 0)
}

/// Whether a segment is empty. iceoryx2 waits without a timeout for such a segment to get its size.
pub(super) fn is_empty(file: &Path) -> bool {
    fs::symlink_metadata(file).is_ok_and(|told| told.is_file() && told.len() == 0)
}
