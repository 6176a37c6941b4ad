//! The memories of a daemon's processes.

use std::collections::BTreeMap;
use std::io;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};
use std::time::Instant;

use genom_blackbox::{Memory, filled};
use genom_configuration::BlackBoxSection;
use genom_ports::dates::Dates;
use genom_protocol::{BlackBox, BlackBoxFile, BlackBoxPart};
use genom_supervisor::Supervisor;

use crate::shelf::{Shelf, size};

/// What names of files begin with.
pub(super) const PREFIX: &str = "blackbox-";

/// A process: the daemon itself (`None`), or a cell.
pub(super) type Of = Option<String>;

/// The black box of a daemon.
pub struct BlackBoxes {
    pub(super) section: BlackBoxSection,
    pub(super) shelf: Shelf,
    memories: Mutex<BTreeMap<Of, Arc<Memory>>>,
    pub(super) daemon: OnceLock<Attached>,
    /// Of a cell, what its daemon lent it.
    pub(super) lent: OnceLock<Memory>,
    reasons: Mutex<Reasons>,
    /// Whoever writes a file has it.
    pub(super) turn: tokio::sync::Mutex<()>,
}

/// The daemon that it is of.
pub(super) struct Attached {
    pub(super) supervisor: Weak<Supervisor>,
    pub(super) dates: Dates,
}

/// What was written for changes, and what was not.
#[derive(Debug, Default)]
pub(super) struct Reasons {
    pub(super) last: Option<Instant>,
    /// Reasons for which no file was written.
    pub(super) skipped: u64,
}

impl std::fmt::Debug for BlackBoxes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("BlackBoxes").field("section", &self.section).finish_non_exhaustive()
    }
}

impl BlackBoxes {
    /// One that keeps nothing yet.
    #[must_use]
    pub fn new(section: &BlackBoxSection) -> Self {
        Self {
            section: section.clone(),
            shelf: Shelf {
                section: "blackbox",
                prefix: PREFIX,
                directory: section.place(),
                most: section.most.max(1),
                most_bytes: section.most_bytes,
                writing: Mutex::default(),
            },
            memories: Mutex::default(),
            daemon: OnceLock::new(),
            lent: OnceLock::new(),
            reasons: Mutex::default(),
            turn: tokio::sync::Mutex::default(),
        }
    }

    pub(crate) fn section(&self) -> &BlackBoxSection {
        &self.section
    }

    pub(super) fn with<T>(&self, work: impl FnOnce(&mut BTreeMap<Of, Arc<Memory>>) -> T) -> T {
        work(&mut self.memories.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// A memory for the next process of a cell; `None` when nothing is to be kept.
    pub(crate) fn begin(&self, cell: &str) -> Option<Arc<Memory>> {
        let made = self.section.enabled.then(|| Memory::new(self.section.bytes))?;
        self.hold(cell, made)
    }

    /// The memory of a process that a daemon before this one started.
    pub(crate) fn adopt(&self, cell: &str, pid: u32) {
        if self.section.enabled {
            let found = Memory::of_process(pid).map_err(io::Error::other);
            self.hold(cell, found);
        }
    }

    fn hold(&self, cell: &str, memory: io::Result<Memory>) -> Option<Arc<Memory>> {
        match memory.map(Arc::new) {
            Ok(memory) => {
                self.with(|all| all.insert(Some(cell.to_owned()), Arc::clone(&memory)));
                Some(memory)
            }
            Err(error) => {
                tracing::warn!("cell {cell}: the black box keeps nothing of this process: {error}");
                None
            }
        }
    }

    /// The process of a cell has ended: what it left.
    pub(crate) fn end(&self, cell: &str) -> Option<Arc<Memory>> {
        self.with(|all| all.remove(&Some(cell.to_owned())))
    }

    /// Those of all processes, the daemon's own first.
    pub(super) fn all(&self) -> Vec<(Of, Arc<Memory>)> {
        self.with(|all| all.iter().map(|(of, one)| (of.clone(), Arc::clone(one))).collect())
    }

    /// How it is; `unmatched` are patterns that match nothing. Blocks a moment.
    #[must_use]
    pub fn told(&self, unmatched: Vec<String>) -> BlackBox {
        let part = |(cell, memory): (Of, Arc<Memory>)| {
            let filled = filled(&memory).unwrap_or_default();
            BlackBoxPart {
                cell,
                tracks: filled.tracks,
                bytes: filled.bytes,
                most_bytes: memory.bytes(),
                memory: memory.taken().unwrap_or_default(),
                taken: filled.taken,
                refused: filled.refused,
            }
        };
        let directory = self.shelf.directory.as_ref();
        let file = |name: String| {
            let bytes = directory.map_or(0, |directory| size(&directory.join(&name)));
            BlackBoxFile { name, bytes }
        };
        let on = self.section.on.iter();
        let reason = |one| serde_json::to_value(one).ok()?.as_str().map(str::to_owned);
        BlackBox {
            enabled: self.section.enabled,
            seconds: self.section.seconds,
            on: on.filter_map(reason).collect(),
            directory: directory.cloned(),
            processes: self.all().into_iter().map(part).collect(),
            files: self.shelf.names().into_iter().map(file).collect(),
            skipped: self.reasons().skipped,
            unmatched,
        }
    }

    pub(super) fn reasons(&self) -> std::sync::MutexGuard<'_, Reasons> {
        self.reasons.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
