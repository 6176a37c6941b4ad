//! Segments that are not whole, and ports that nobody has any more.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

use super::Healed;
use super::nodes::{self, Tags};
use super::places::{Places, entries};
use super::services;

/// How long the counter of nodes may take to be made: system calls without a wait between them.
const BIRTH: Duration = Duration::from_millis(50);

/// Its bytes: a version, and a count.
const COUNTER: u64 = 16;

/// Smallest identity: its upper half holds a process, and is never zero.
const LEAST: u128 = 1 << 64;

/// The segments of a prefix.
pub(super) struct Segments {
    /// Names, by each of the identities in them.
    by_id: BTreeMap<u128, Vec<String>>,
}

impl Segments {
    pub(super) fn list(places: &Places) -> Self {
        let mut by_id = BTreeMap::<u128, Vec<String>>::new();
        for name in entries(&places.segments) {
            for id in ids(places, &name) {
                by_id.entry(id).or_default().push(name.clone());
            }
        }
        Self { by_id }
    }

    fn of(&self, id: u128) -> impl Iterator<Item = &String> {
        self.by_id.get(&id).into_iter().flatten()
    }
}

/// The identities in the name of a segment: `PREFIX KIND _ID`, `_ID_ID` for a connection.
pub(super) fn ids(places: &Places, name: &str) -> impl Iterator<Item = u128> + use<> {
    let stem = name.strip_prefix(places.prefix.as_str()).unwrap_or_default();
    let stem = stem.split('.').next().unwrap_or_default();
    let parts: Vec<u128> = stem.split('_').filter_map(|part| part.parse().ok()).collect();
    parts.into_iter().filter(|id| *id >= LEAST)
}

/// Whether a file was never finished: iceoryx2 gives it its size first, and the right to read it
/// last.
fn is_unfinished(file: &Path) -> bool {
    is_unreadable(file) || is_empty(file)
}

/// Whether its owner may not read a file.
pub(super) fn is_unreadable(file: &Path) -> bool {
    const READ: u32 = 0o400;
    fs::symlink_metadata(file).is_ok_and(|told| told.is_file() && told.mode() & READ == 0)
}

/// Whether a segment has no bytes: whoever opens it waits until it has some, without an end.
fn is_empty(file: &Path) -> bool {
    fs::symlink_metadata(file).is_ok_and(|told| told.is_file() && told.len() == 0)
}

/// Segments without bytes, and the processes their names tell of.
pub(super) fn empty(places: &Places) -> Vec<(PathBuf, Vec<u32>)> {
    let own = entries(&places.segments).filter(|name| name.starts_with(&places.prefix));
    let found = own.map(|name| {
        let processes: Vec<u32> = ids(places, &name).map(nodes::process).collect();
        (places.segments.join(name), processes)
    });
    found.filter(|(file, _)| is_empty(file)).collect()
}

/// The counters of nodes of a prefix: one a version of iceoryx2.
pub(super) fn counters(places: &Places) -> Vec<PathBuf> {
    let named = |name: &String| name.starts_with(&places.prefix) && name.ends_with(&places.counter);
    entries(&places.segments).filter(named).map(|name| places.segments.join(name)).collect()
}

/// Removes the counter of nodes when it was never finished, or cut: no node starts with it.
pub(super) fn counter(places: &Places, healed: &mut Healed) {
    for file in counters(places) {
        let short = || fs::symlink_metadata(&file).is_ok_and(|told| told.len() < COUNTER);
        let end = Instant::now() + BIRTH;
        while is_unfinished(&file) || short() {
            if Instant::now() > end {
                healed.remove(file.clone());
                break;
            }
            thread::park_timeout(Duration::from_millis(1));
        }
    }
}

/// Removes what dead nodes began: segments of their ports, services they were making.
pub(super) fn unfinished(
    places: &Places,
    segments: &Segments,
    dead: &Tags,
    living: Option<&BTreeSet<String>>,
    healed: &mut Healed,
) {
    for name in dead.ports.iter().flat_map(|port| segments.of(*port)) {
        let file = places.segments.join(name);
        if is_unfinished(&file) {
            healed.remove(file);
        }
    }
    let Some(living) = living else { return };
    for hash in dead.services.difference(living) {
        let file = services::file(places, hash);
        if is_unfinished(&file) {
            healed.remove(file);
        } else if let Some(id) = services::identity(&file) {
            for name in segments.of(id) {
                let file = places.segments.join(name);
                if is_unfinished(&file) {
                    healed.remove(file);
                }
            }
        }
    }
}

/// Removes segments of ports that nobody alive has an end of.
pub(super) fn ports(places: &Places, dead: &Tags, healed: &mut Healed) {
    // Listeners have a socket in the folder, too.
    for folder in [&places.segments, &places.root] {
        for name in entries(folder) {
            let mut ends = ids(places, &name).peekable();
            if ends.peek().is_some() && ends.all(|id| dead.ports.contains(&id)) {
                healed.remove(folder.join(name));
            }
        }
    }
}
