//! Distinguishes nodes whose process lives from nodes whose process is gone.

use std::collections::BTreeSet;
use std::fs::{self, OpenOptions, Permissions};
use std::io::{self, Write as _};
use std::os::unix::fs::{MetadataExt as _, OpenOptionsExt as _, PermissionsExt as _};
use std::path::Path;
use std::sync::OnceLock;
use std::thread;
use std::time::{Duration, Instant, SystemTime};

use iceoryx2::node::{
    DeadNodeView, Node, NodeCleanupFailure, NodeDetails, NodeState, NodeView as _,
};
use iceoryx2::prelude::*;
use rustix::process::{Flock, FlockType, fcntl_getlk};

use super::files::is_unreadable;
use super::healed::Healed;
use super::places::{Places, entries};
use crate::raw::Ipc;

/// How long creating or removing a node may take: system calls with no wait in between.
const BIRTH: Duration = Duration::from_millis(200);

/// How long another process may take to remove a dead node.
const REMOVAL: Duration = Duration::from_millis(500);

/// Polling interval during these times.
const TICK: Duration = Duration::from_millis(5);

/// What a node created or has open, according to the tags in its folder.
#[derive(Debug, Default)]
pub(super) struct Tags {
    pub(super) ports: BTreeSet<u128>,
    /// Hashes that identify services.
    pub(super) services: BTreeSet<String>,
}

/// The existing nodes.
#[derive(Debug, Default)]
pub(super) struct Nodes {
    pub(super) living: BTreeSet<u128>,
    pub(super) dead: BTreeSet<u128>,
    /// Being created or removed: not known yet to be alive or dead.
    unsettled: BTreeSet<u128>,
}

impl Nodes {
    /// Waits for nodes that are being created or removed. Those that do not finish in time are
    /// dead.
    pub(super) fn settled(config: &Config, places: &Places) -> Self {
        let end = Instant::now() + BIRTH;
        loop {
            let mut nodes = Self::look(config, places);
            let young = nodes.unsettled.iter().any(|id| is_young(places, *id));
            if !young || Instant::now() > end {
                nodes.dead.append(&mut nodes.unsettled);
                return nodes;
            }
            thread::park_timeout(TICK);
        }
    }

    pub(super) fn look(config: &Config, places: &Places) -> Self {
        let mut nodes = Self::default();
        // List the files before checking processes: a node created in between is not in the list,
        // and so is not taken for dead.
        for name in entries(&places.nodes) {
            let id = match places.name(&name, "") {
                Some(rest) => rest.split(places.monitor.as_str()).next().unwrap_or_default(),
                None => &name,
            };
            nodes.unsettled.extend(id.parse::<u128>());
        }
        let sorted = Node::<Ipc>::list(config, |state| {
            let id = state.node_id().value();
            nodes.unsettled.remove(&id);
            match state {
                NodeState::Alive(_) | NodeState::Inaccessible(_) => nodes.living.insert(id),
                NodeState::Dead(_) if is_being_cleaned(places, id) => nodes.living.insert(id),
                NodeState::Dead(_) => nodes.dead.insert(id),
                NodeState::Undefined(_) => nodes.unsettled.insert(id),
            };
            CallbackProgression::Continue
        });
        if let Err(error) = sorted {
            tracing::debug!(%error, "nodes cannot be listed");
        }
        for id in std::mem::take(&mut nodes.unsettled) {
            let [state, ..] = places.monitor(id);
            if !is_own(id) && is_locked(&state) {
                nodes.living.insert(id);
            } else {
                nodes.unsettled.insert(id);
            }
        }
        nodes
    }

    pub(super) fn tags_of_dead(&self, places: &Places) -> Tags {
        let mut tags = Tags::default();
        for id in &self.dead {
            for name in entries(&places.node(*id)) {
                if let Some(port) = places.name(&name, &places.port_tag) {
                    tags.ports.extend(port.parse::<u128>());
                } else if let Some(service) = places.name(&name, &places.service_tag) {
                    tags.services.insert(service.to_owned());
                }
            }
        }
        tags
    }

    /// Services that living nodes have or are creating; `None` if the folder of a node cannot be
    /// read.
    pub(super) fn tags_of_living(&self, places: &Places) -> Option<BTreeSet<String>> {
        let mut services = BTreeSet::new();
        for id in &self.living {
            let folder = places.node(*id);
            match fs::read_dir(&folder) {
                Ok(_) => {}
                // The node was removed meanwhile.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(_) => return None,
            }
            let tagged = entries(&folder)
                .filter_map(|name| Some(places.name(&name, &places.service_tag)?.to_owned()));
            services.extend(tagged);
        }
        Some(services)
    }
}

/// Whether a node belongs to this process, or to an earlier one with the same process id. The locks
/// of this process must not be tested: closing any descriptor of a file gives up the lock on it.
fn is_own(id: u128) -> bool {
    process(id) == own()
}

/// The process id of this process as iceoryx2 writes it into identities: the outermost one that the
/// system reports, which differs from the inner one in a container that sees the host's `/proc`.
fn own() -> u32 {
    static OWN: OnceLock<u32> = OnceLock::new();
    *OWN.get_or_init(|| {
        let told = fs::read_to_string("/proc/self/status").unwrap_or_default();
        let numbers = told.lines().find_map(|line| line.strip_prefix("NSpid:"));
        let first = numbers.and_then(|numbers| numbers.split_whitespace().next()?.parse().ok());
        first.unwrap_or_else(std::process::id)
    })
}

/// The process id of a node, port or service, taken from its identity.
pub(super) fn process(id: u128) -> u32 {
    #[allow(clippy::cast_possible_truncation, reason = "32 of its bits")]
    let process = (id >> 64) as u32;
    process
}

/// Whether some process holds a lock on the file. A file of another user counts as locked.
fn is_locked(file: &Path) -> bool {
    let file = match OpenOptions::new().write(true).open(file) {
        Ok(file) => file,
        Err(error) => return error.kind() == io::ErrorKind::PermissionDenied,
    };
    let whole = Flock::from(FlockType::WriteLock);
    fcntl_getlk(&file, &whole).is_ok_and(|holder| holder.is_some())
}

/// The nodes that have a monitoring file, alive or dead.
fn shown(places: &Places) -> impl Iterator<Item = u128> {
    let named = |name: String| places.name(&name, &places.monitor)?.parse::<u128>().ok();
    entries(&places.nodes).filter_map(named)
}

/// Whether the process of some node is gone.
pub(super) fn somebody_died(places: &Places) -> bool {
    shown(places).any(|id| {
        let [state, ..] = places.monitor(id);
        // A node that is being created has no lock yet, and its file is not readable.
        let made = || !is_unreadable(&state) || !is_young(places, id);
        !is_own(id) && !is_locked(&state) && made()
    })
}

/// Process ids of the living nodes, including this one.
pub(super) fn living_processes(places: &Places) -> BTreeSet<u32> {
    let living = shown(places).filter(|id| is_own(*id) || is_locked(&places.monitor(*id)[0]));
    living.map(process).chain([own()]).collect()
}

/// Whether a living process is removing a dead node.
fn is_being_cleaned(places: &Places, id: u128) -> bool {
    let [_, cleaner, _] = places.monitor(id);
    !is_own(id) && is_locked(&cleaner)
}

fn is_young(places: &Places, id: u128) -> bool {
    let [state, cleaner, context] = places.monitor(id);
    [state, cleaner, context, places.node(id)].iter().any(|path| {
        let Ok(told) = fs::symlink_metadata(path) else { return false };
        let changed = Duration::new(
            u64::try_from(told.ctime()).unwrap_or_default(),
            u32::try_from(told.ctime_nsec()).unwrap_or_default(),
        );
        // A time in the future counts as young, because clocks may be set back.
        let age = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH + changed);
        age.is_ok_and(|age| age < BIRTH)
    })
}

/// Makes iceoryx2 remove dead nodes. Returns how many there were.
pub(super) fn clean(
    config: &Config,
    places: &Places,
    dead: &BTreeSet<u128>,
    healed: &mut Healed,
) -> usize {
    for id in dead {
        if let Err(error) = complete(places, *id) {
            tracing::debug!(%error, id, "the files of a dead node cannot be completed");
        }
    }
    let mut given_up = dead.clone();
    let cleaned = Node::<Ipc>::list(config, |state| {
        if let NodeState::Dead(node) = state
            && dead.contains(&node.id().value())
        {
            // Uses our own folder, not the one named in the node's file, so that nobody can
            // redirect the removal.
            let (id, details) = (*node.id(), NodeDetails::__internal_new(&None, config));
            // Waits for its turn: iceoryx2 removes one node at a time in a process.
            let done = DeadNodeView::<Ipc>::__internal_blocking_remove_stale_resources(
                id, details, REMOVAL,
            );
            if let Err(error) = done {
                tracing::warn!(%error, id = id.value(), "iceoryx2 does not remove a dead node");
                if error == NodeCleanupFailure::AnotherInstanceIsCleaningUpTheNode {
                    // Another process removes it, or the next pass does.
                    given_up.remove(&id.value());
                }
            }
        }
        CallbackProgression::Continue
    });
    if let Err(error) = cleaned {
        tracing::debug!(%error, "nodes cannot be listed");
    }
    for id in given_up {
        let folder = places.node(id);
        for name in entries(&folder) {
            healed.remove(folder.join(name));
        }
        let _ = fs::remove_dir(&folder);
        for file in places.monitor(id) {
            healed.remove(file);
        }
    }
    dead.len()
}

/// Creates those files that iceoryx2 needs to recognise a dead node. A process that was killed
/// while creating or removing them left only some.
fn complete(places: &Places, id: u128) -> io::Result<()> {
    let files = places.monitor(id);
    let modes = [0o600, 0o600, 0o400];
    for (file, mode) in files.iter().zip(modes) {
        let mut options = OpenOptions::new();
        let opened = options.write(true).create_new(true).mode(0o600).open(file);
        let context = file == &files[2];
        match opened {
            // The process it belonged to; any id but this process's will do.
            Ok(mut opened) if context => opened.write_all(&id.to_ne_bytes())?,
            Ok(_) => {}
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {
                let short = context && fs::metadata(file)?.len() < 16;
                if short {
                    fs::set_permissions(file, Permissions::from_mode(0o600))?;
                    fs::write(file, id.to_ne_bytes())?;
                }
            }
            Err(error) => return Err(error),
        }
        fs::set_permissions(file, Permissions::from_mode(mode))?;
    }
    Ok(())
}
