//! Where a middleware's own thread stores the last message for the reader to copy.

use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::FloorError;
use crate::pair::Receive;

/// Holds the last message as the middleware delivers it, without a copy.
pub(super) struct Place<M> {
    count: AtomicU64,
    message: Mutex<Option<M>>,
}

/// The reader's end; `K` is what must stay alive for messages to arrive.
pub(super) struct Looks<M, K> {
    place: Arc<Place<M>>,
    seen: u64,
    bytes: Vec<u8>,
    copy: fn(&M, &mut Vec<u8>),
    _keep: K,
}

impl<M> Place<M> {
    pub(super) fn new() -> Arc<Self> {
        Arc::new(Self { count: AtomicU64::new(0), message: Mutex::new(None) })
    }

    pub(super) fn put(&self, message: M) {
        *self.message.lock().unwrap_or_else(PoisonError::into_inner) = Some(message);
        self.count.fetch_add(1, Ordering::Release);
    }
}

impl<M, K> Looks<M, K> {
    pub(super) fn at(place: Arc<Place<M>>, copy: fn(&M, &mut Vec<u8>), keep: K) -> Self {
        Self { place, seen: 0, bytes: Vec::new(), copy, _keep: keep }
    }
}

impl<M, K> Receive for Looks<M, K> {
    fn arrived(&mut self) -> Result<bool, FloorError> {
        let count = self.place.count.load(Ordering::Acquire);
        if count == self.seen {
            return Ok(false);
        }
        self.seen = count;
        let message = self.place.message.lock().unwrap_or_else(PoisonError::into_inner).take();
        self.bytes.clear();
        message.iter().for_each(|message| (self.copy)(message, &mut self.bytes));
        black_box(&mut self.bytes);
        Ok(true)
    }
}
