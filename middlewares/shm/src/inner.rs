//! What all ports and services of one node share.

use std::sync::{Arc, Mutex, PoisonError};

use genom_middleware::{Address, OpenError};

use crate::calls::Worker;
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
    /// Made when the first service is served or called.
    worker: Mutex<Option<Arc<Worker>>>,
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
        Self { worker: Mutex::default(), upkeep, ground: Arc::new(ground), _last: Last(watch) }
    }

    /// The thread that hands on requests and responses.
    pub(crate) fn worker(&self, at: &Address) -> Result<Arc<Worker>, OpenError> {
        let mut worker = self.worker.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(worker) = &*worker {
            return Ok(Arc::clone(worker));
        }
        Ok(Arc::clone(worker.insert(Arc::new(Worker::start(&self.ground, at)?))))
    }
}
