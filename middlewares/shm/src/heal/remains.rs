//! Incomplete segments, and segments of ports that no living node has open.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use super::files::{ids, is_empty, is_unfinished};
use super::healed::Healed;
use super::nodes::{self, Tags};
use super::places::{Places, entries};
use super::services;

/// How long creating the node counter may take: system calls with no wait in between.
const BIRTH: Duration = Duration::from_millis(50);

/// Size of the counter in bytes: a version and a count.
const COUNTER: u64 = 16;

/// The segments with one prefix.
pub(super) struct Segments {
    /// Names of segments, by each identity in them.
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

/// Empty segments, with the process ids in their names.
pub(super) fn empty(places: &Places) -> Vec<(PathBuf, Vec<u32>)> {
    let own = entries(&places.segments).filter(|name| name.starts_with(&places.prefix));
    let found = own.map(|name| {
        let processes: Vec<u32> = ids(places, &name).map(nodes::process).collect();
        (places.segments.join(name), processes)
    });
    found.filter(|(file, _)| is_empty(file)).collect()
}

/// The node counters of a prefix: one per version of iceoryx2.
pub(super) fn counters(places: &Places) -> Vec<PathBuf> {
    let named = |name: &String| name.starts_with(&places.prefix) && name.ends_with(&places.counter);
    entries(&places.segments).filter(named).map(|name| places.segments.join(name)).collect()
}

/// Removes the node counter if it was never completed or was truncated, since no node could start
/// with it.
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

/// Removes what dead nodes were creating: segments of their ports, and services.
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

/// Removes segments of ports that no living node has open.
pub(super) fn ports(places: &Places, dead: &Tags, healed: &mut Healed) {
    // Listeners also have a socket in the root folder.
    for folder in [&places.segments, &places.root] {
        for name in entries(folder) {
            let mut ends = ids(places, &name).peekable();
            if ends.peek().is_some() && ends.all(|id| dead.ports.contains(&id)) {
                healed.remove(folder.join(name));
            }
        }
    }
}
