//! What all that is opened from one node shares.

use std::sync::Arc;

use crate::ground::Ground;
use crate::upkeep::Upkeep;
use crate::watch::Watch;

/// Removes what others left, when the node is gone.
struct Last(Watch);

impl Drop for Last {
    fn drop(&mut self) {
        let _ = self.0.watcher().heal();
    }
}

/// A node, and the threads that look after what is opened from it.
pub(crate) struct Inner {
    /// Its thread is stopped before the node goes.
    pub(crate) upkeep: Upkeep,
    pub(crate) ground: Arc<Ground>,
    /// Looks after the end of the node, too.
    _last: Last,
}

impl Inner {
    /// Nothing is open yet.
    pub(crate) fn new(ground: Ground, watch: Watch) -> Self {
        let upkeep = Upkeep::start(watch.watcher().clone());
        Self { upkeep, ground: Arc::new(ground), _last: Last(watch) }
    }
}
