//! What a pass removed.

use std::path::PathBuf;
use std::time::Instant;

/// What a pass removed.
#[derive(Debug, Default)]
pub(crate) struct Healed {
    /// Nodes whose process is gone.
    pub(super) nodes: usize,
    files: Vec<PathBuf>,
}

impl Healed {
    /// Whether there was a node whose process is gone.
    pub(crate) fn found_nodes(&self) -> bool {
        self.nodes > 0
    }

    /// Removes a file that nobody needs.
    pub(super) fn remove(&mut self, file: PathBuf) {
        if std::fs::remove_file(&file).is_ok() {
            self.files.push(file);
        }
    }

    /// Says so, in the log of one that began then.
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
