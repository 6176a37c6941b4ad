//! Services that no node uses.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use iceoryx2::prelude::Config;

use super::files::ids;
use super::healed::Healed;
use super::nodes::{Nodes, process};
use super::places::{Places, entries};

/// The file that describes a service.
pub(super) fn file(places: &Places, hash: &str) -> PathBuf {
    places.services.join(format!("{}{hash}{}", places.prefix, places.service))
}

/// Identity of a service, read from the file that describes it.
pub(super) fn identity(file: &Path) -> Option<u128> {
    let text = std::fs::read_to_string(file).ok()?;
    let (_, after) = text.split_once("[unique_service_id]")?;
    let number = |key: &str| {
        let mut lines = after.lines().take_while(|line| !line.starts_with('['));
        let value = lines.find_map(|line| line.strip_prefix(key)?.trim().strip_prefix('='))?;
        value.trim().parse::<u64>().ok()
    };
    let (low, high) = (number("payload_value")?, number("unique_value")?);
    Some(u128::from(high) << 64 | u128::from(low))
}

/// The existing services, by the hashes that identify them.
pub(super) fn list(places: &Places) -> Vec<String> {
    let named = |name: String| Some(places.name(&name, &places.service)?.to_owned());
    entries(&places.services).filter_map(named).collect()
}

/// Removes services for which no living node has the tag: their last owner was killed while it
/// created or removed them. A node writes the tag before it creates a service, and removes the tag
/// after it has left the service.
pub(super) fn orphans(
    config: &Config,
    places: &Places,
    there: &[String],
    nodes: &Nodes,
    healed: &mut Healed,
) {
    let without = |nodes: &Nodes| -> Option<BTreeSet<String>> {
        let tagged = nodes.tags_of_living(places)?;
        Some(there.iter().filter(|hash| !tagged.contains(*hash)).cloned().collect())
    };
    let Some(orphans) = without(nodes) else { return };
    if orphans.is_empty() {
        return;
    }
    // Check again: a new node may have opened one of them meanwhile.
    let Some(again) = without(&Nodes::look(config, places)) else { return };
    let segments: Vec<String> = entries(&places.segments).collect();
    for hash in orphans.intersection(&again) {
        let file = file(places, hash);
        let id = identity(&file);
        let own = |name: &&String| id.is_some_and(|id| ids(places, name).any(|found| found == id));
        for name in segments.iter().filter(own) {
            healed.remove(places.segments.join(name));
        }
        healed.remove(file);
    }
}

/// Removes what dead processes had of services whose description was truncated or removed. Segments
/// with the same prefix may belong to another root folder, so only segments of processes that had a
/// node here, and have none now, are removed.
pub(super) fn undescribed(places: &Places, nodes: &Nodes, healed: &mut Healed) {
    let gone = |id: u128| {
        let of = |ids: &BTreeSet<u128>| ids.iter().any(|node| process(*node) == process(id));
        let running = Path::new("/proc").join(process(id).to_string()).exists();
        of(&nodes.dead) && !of(&nodes.living) && !running
    };
    let all = entries(&places.segments).filter(|name| name.ends_with(&places.dynamic));
    let left = all.filter_map(|name| ids(places, &name).next().map(|id| (id, name)));
    let left: Vec<(u128, String)> = left.filter(|(id, _)| gone(*id)).collect();
    if left.is_empty() {
        return;
    }
    let described = list(places).into_iter().filter_map(|hash| identity(&file(places, &hash)));
    let described: BTreeSet<u128> = described.collect();
    for (_, name) in left.into_iter().filter(|(id, _)| !described.contains(id)) {
        healed.remove(places.segments.join(name));
    }
}
