//! What all services of one node share.

use std::sync::{Arc, Mutex};

use genom_middleware::{Address, OpenError};

use super::bell::lock;
use super::worker::Worker;
use crate::inner::Inner;

/// A node and the thread that passes on its requests and responses. Fields are dropped in order.
pub(crate) struct Desk {
    /// Started when the first service is served or called.
    worker: Mutex<Option<Arc<Worker>>>,
    pub(super) inner: Arc<Inner>,
}

impl Desk {
    /// No services yet.
    pub(crate) fn new(inner: &Arc<Inner>) -> Arc<Self> {
        Arc::new(Self { worker: Mutex::default(), inner: Arc::clone(inner) })
    }

    /// The thread; starts it if necessary.
    pub(super) fn worker(&self, at: &Address) -> Result<Arc<Worker>, OpenError> {
        let mut worker = lock(&self.worker);
        if let Some(worker) = &*worker {
            return Ok(Arc::clone(worker));
        }
        Ok(Arc::clone(worker.insert(Arc::new(Worker::start(&self.inner.ground, at)?))))
    }
}
