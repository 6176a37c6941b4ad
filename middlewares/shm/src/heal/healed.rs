//! What a healing pass removed.

use std::path::PathBuf;
use std::time::Instant;

/// What a pass removed.
#[derive(Debug, Default)]
pub(crate) struct Healed {
    /// Number of nodes whose process is gone.
    pub(super) nodes: usize,
    files: Vec<PathBuf>,
}

impl Healed {
    /// Whether there was a node whose process is gone.
    pub(crate) fn found_nodes(&self) -> bool {
        self.nodes > 0
    }

    /// Removes an unneeded file.
    pub(super) fn remove(&mut self, file: PathBuf) {
        if std::fs::remove_file(&file).is_ok() {
            self.files.push(file);
        }
    }

    /// Logs what was removed; `begin` is when the pass began.
    pub(super) fn tell(&self, begin: Instant) {
        for file in &self.files {
            tracing::debug!(file = %file.display(), "removed: its process is gone");
        }
        let milliseconds = begin.elapsed().as_millis();
        if let Some(first) = self.files.first() {
            tracing::warn!(
                nodes = self.nodes,
                damaged = self.files.len(),
                first = %first.display(),
                milliseconds,
                "removed what processes left on shared memory that were killed"
            );
        } else if self.nodes > 0 {
            tracing::info!(
                nodes = self.nodes,
                milliseconds,
                "removed what processes left on shared memory that were killed"
            );
        }
    }
}
