//! Segments that are not whole, and ports that nobody has any more.

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

/// How long the counter of nodes may take to be made: system calls without a wait between them.
const BIRTH: Duration = Duration::from_millis(50);

/// Its bytes: a version, and a count.
const COUNTER: u64 = 16;

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
