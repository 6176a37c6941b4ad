//! State shared by everything that is opened from one node.

use std::sync::Arc;

use crate::ground::Ground;
use crate::upkeep::Upkeep;
use crate::watch::Watch;

/// After the node is dropped, removes what others left.
struct Last(Watch);

impl Drop for Last {
    fn drop(&mut self) {
        let _ = self.0.watcher().heal();
    }
}

/// A node, and the threads that maintain what is opened from it.
pub(crate) struct Inner {
    /// Its thread is stopped before the node is dropped.
    pub(crate) upkeep: Upkeep,
    pub(crate) ground: Arc<Ground>,
    /// Also covers dropping the node.
    _last: Last,
}

impl Inner {
    /// Nothing is open yet.
    pub(crate) fn new(ground: Ground, watch: Watch) -> Self {
        let upkeep = Upkeep::start(watch.watcher().clone());
        Self { upkeep, ground: Arc::new(ground), _last: Last(watch) }
    }
}
