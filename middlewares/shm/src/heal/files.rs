//! What name and state of a file tell.

use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

use super::places::Places;

/// Smallest identity: its upper half holds a process, and is never zero.
const LEAST: u128 = 1 << 64;

/// The identities in the name of a segment: `PREFIX KIND _ID`, `_ID_ID` for a connection.
pub(super) fn ids(places: &Places, name: &str) -> impl Iterator<Item = u128> + use<> {
    let stem = name.strip_prefix(places.prefix.as_str()).unwrap_or_default();
    let stem = stem.split('.').next().unwrap_or_default();
    let parts: Vec<u128> = stem.split('_').filter_map(|part| part.parse().ok()).collect();
    parts.into_iter().filter(|id| *id >= LEAST)
}

/// Whether a file was never finished: iceoryx2 gives it its size first, and the right to read it
/// last.
pub(super) fn is_unfinished(file: &Path) -> bool {
    is_unreadable(file) || is_empty(file)
}

/// Whether its owner may not read a file.
pub(super) fn is_unreadable(file: &Path) -> bool {
    const READ: u32 = 0o400;
    fs::symlink_metadata(file).is_ok_and(|told| told.is_file() && told.mode() & READ == 0)
}

/// Whether a segment has no bytes: whoever opens it waits until it has some, without an end.
pub(super) fn is_empty(file: &Path) -> bool {
    fs::symlink_metadata(file).is_ok_and(|told| told.is_file() && told.len() == 0)
}
