//! Removes what killed processes left in shared memory.
//!
//! iceoryx2 removes what a dead node registered, provided that every file is complete. A process
//! that is killed between two system calls leaves incomplete ones: an empty segment, on which every
//! process that opens it waits; a service without its description; a node with some of its files.
//! So before iceoryx2 accesses anything, and whenever something blocks, a pass removes what no
//! living process can be creating or using:
//!
//! 1. `nodes` distinguishes living nodes from dead ones by file locks, which end with their process.
//!    Locks work across containers, where process numbers mean nothing.
//! 2. A node writes a tag for what it is about to create before it creates it. So a file for which
//!    only dead nodes have the tag is not in use: `remains` removes those that are incomplete.
//! 3. Incomplete dead nodes are completed, so that iceoryx2's own clean-up removes them, together
//!    with their part in the services and ports that they shared with living peers.
//! 4. `services` removes services for which no living node has the tag, and catalogs of dead daemons.
//!
//! Passes exclude each other by a lock on the folder itself, which ends with the process and leaves
//! no file behind. Memory that living peers have mapped stays mapped, and their files are not
//! touched.

mod files;
mod healed;
mod nodes;
mod places;
mod remains;
mod services;
mod turn;

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::Instant;

use iceoryx2::prelude::Config;

use crate::catalog;
pub(crate) use healed::Healed;
use nodes::Nodes;
pub(crate) use places::{Places, SEGMENTS};
use remains::Segments;
pub(crate) use turn::Turn;

/// Runs a pass. A folder that cannot be read is skipped: opening something in it reports the error.
pub(crate) fn heal(config: &Config, places: &Places, _turn: &Turn) -> Healed {
    let begin = Instant::now();
    let mut healed = Healed::default();
    remains::counter(places, &mut healed);
    // List services and catalogs before nodes, so that the node of whoever created one is among
    // those found.
    let there = services::list(places);
    let catalogs = catalog::list(&places.root, &places.prefix);
    let nodes = Nodes::settled(config, places);
    if !nodes.dead.is_empty() {
        let tags = nodes.tags_of_dead(places);
        let living = nodes.tags_of_living(places);
        let segments = Segments::list(places);
        remains::unfinished(places, &segments, &tags, living.as_ref(), &mut healed);
        healed.nodes = nodes::clean(config, places, &nodes.dead, &mut healed);
        remains::ports(places, &tags, &mut healed);
    }
    services::orphans(config, places, &there, &nodes, &mut healed);
    services::undescribed(places, &nodes, &mut healed);
    for (_, file) in catalogs.into_iter().filter(|(node, _)| !nodes.living.contains(node)) {
        let _ = std::fs::remove_file(file);
    }
    healed.tell(begin);
    healed
}

/// Whether the process of some node is gone. Costs a few system calls per node.
pub(crate) fn somebody_died(places: &Places) -> bool {
    nodes::somebody_died(places)
}

/// Process ids of the living nodes, including this one.
pub(crate) fn living_processes(places: &Places) -> BTreeSet<u32> {
    nodes::living_processes(places)
}

/// Empty segments, with the process ids in their names.
pub(crate) fn empty_segments(places: &Places) -> Vec<(PathBuf, Vec<u32>)> {
    remains::empty(places)
}

/// The segments in which iceoryx2 counts nodes.
pub(crate) fn counters(places: &Places) -> Vec<PathBuf> {
    remains::counters(places)
}
