//! Removes what processes left on shared memory that ended where they stood.
//!
//! iceoryx2 removes what a dead node registered, as long as every file is whole. A process that
//! ends between two system calls leaves some that are not: a segment of no bytes, on which every
//! process waits that opens it, a service whose description was never written, a node whose files
//! are there in part. So before iceoryx2 looks at anything, and when something hangs, a pass
//! removes what nobody alive can be making or using:
//!
//! 1. `nodes` tells the living from the dead by the locks that end with a process. Locks hold
//!    across containers, where process numbers say nothing.
//! 2. A node tags what it is about to make, before it makes it. So a file of which only dead
//!    nodes have the tag is in nobody's hands: `remains` removes those that are not whole.
//! 3. Nodes that are there in part are completed, so that iceoryx2's own clean-up takes them, and
//!    the services and ports they have together with living peers with them.
//! 4. `services` removes services of which no living node has the tag, and the catalogs of what
//!    dead daemons offered go.
//!
//! Passes take turns by a lock on the folder itself, which ends with the process and leaves no
//! file behind. What living peers have mapped stays mapped, and their files are not touched.

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
pub(crate) use places::Places;
use remains::Segments;
pub(crate) use turn::Turn;

/// A pass. Where folders cannot be read it does what it can: what needs them says why it fails.
pub(crate) fn heal(config: &Config, places: &Places, _turn: &Turn) -> Healed {
    let begin = Instant::now();
    let mut healed = Healed::default();
    remains::counter(places, &mut healed);
    // Services and catalogs before nodes: whoever made one that is there now is among the nodes.
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

/// Whether the process of some node is gone: a few system calls a node.
pub(crate) fn somebody_died(places: &Places) -> bool {
    nodes::somebody_died(places)
}

/// The processes of living nodes, this one included.
pub(crate) fn living_processes(places: &Places) -> BTreeSet<u32> {
    nodes::living_processes(places)
}

/// Segments without bytes, and the processes their names tell of.
pub(crate) fn empty_segments(places: &Places) -> Vec<(PathBuf, Vec<u32>)> {
    remains::empty(places)
}

/// The segments in which iceoryx2 counts nodes.
pub(crate) fn counters(places: &Places) -> Vec<PathBuf> {
    remains::counters(places)
}
