//! Hands samples from a real-time publisher to a middleware's own thread.
//!
//! For middlewares whose calls may block or allocate: the publisher copies its sample into a
//! buffer made beforehand and rings a [`Bell`]; the thread sends it. When the thread lags, the
//! oldest samples are given up and counted: the newest always goes out.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use genom_types::{DataType, Record};

use crate::bell::Bell;
use crate::index_ring::{IndexRing, MAX_INDEX};

#[derive(Debug)]
struct Shared {
    /// One buffer more than the ring and the reader hold: the writer always finds a free one.
    buffers: Box<[Buffer]>,
    ring: IndexRing,
    dropped: AtomicU64,
    bell: Arc<Bell>,
}

#[derive(Debug)]
struct Buffer {
    /// Never contended: a buffer belongs to the writer while free, then to who took its index.
    /// The lock is there so that this needs no unsafe code.
    record: Mutex<Record>,
    used: AtomicBool,
}

/// The real-time end.
#[derive(Debug)]
pub struct OutboxWriter {
    shared: Arc<Shared>,
    /// Where the search for a free buffer starts.
    hint: usize,
}

/// The middleware thread's end.
#[derive(Debug)]
pub struct OutboxReader {
    shared: Arc<Shared>,
}

/// An outbox for at most `depth` unsent samples (1: only the newest counts).
#[must_use]
pub fn outbox(ty: &DataType, depth: usize, bell: Arc<Bell>) -> (OutboxWriter, OutboxReader) {
    let depth = depth.clamp(1, MAX_INDEX - 2);
    let buffer = || Buffer { record: Mutex::new(Record::new(ty)), used: AtomicBool::new(false) };
    let shared = Arc::new(Shared {
        buffers: (0..depth + 2).map(|_| buffer()).collect(),
        ring: IndexRing::new(depth),
        dropped: AtomicU64::new(0),
        bell,
    });
    (OutboxWriter { shared: Arc::clone(&shared), hint: 0 }, OutboxReader { shared })
}

impl OutboxWriter {
    /// Hands over a copy. Wait-free; allocates nothing for fixed-size types, nor for others once
    /// the buffers have grown. False when the value is of another type.
    pub fn put(&mut self, value: &Record) -> bool {
        let shared = &*self.shared;
        let count = shared.buffers.len();
        let free = (0..count).map(|i| (self.hint + i) % count).find(|&i| {
            shared.buffers.get(i).is_some_and(|buffer| !buffer.used.load(Ordering::Acquire))
        });
        let Some((index, buffer)) = free.and_then(|i| Some((i, shared.buffers.get(i)?))) else {
            return false;
        };
        let Ok(mut record) = buffer.record.try_lock() else { return false };
        if record.copy_from(value).is_err() {
            return false;
        }
        drop(record);
        buffer.used.store(true, Ordering::Release);
        self.hint = index + 1;
        if let Some(lost) = shared.ring.push_over(index) {
            shared.release(lost);
            shared.dropped.fetch_add(1, Ordering::Relaxed);
        }
        shared.bell.ring();
        true
    }

    /// Samples given up so far because the reader lagged.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.shared.dropped.load(Ordering::Relaxed)
    }
}

impl OutboxReader {
    /// Gives the oldest unsent sample to `send`, if there is one. The writer goes on meanwhile.
    pub fn take<R>(&mut self, send: impl FnOnce(&Record) -> R) -> Option<R> {
        let index = self.shared.ring.pop()?;
        let buffer = self.shared.buffers.get(index)?;
        let sent = buffer.record.lock().ok().map(|record| send(&record));
        self.shared.release(index);
        sent
    }

    /// Whether the writer is gone; what it left can still be taken.
    #[must_use]
    pub fn is_abandoned(&self) -> bool {
        Arc::strong_count(&self.shared) == 1
    }
}

impl Shared {
    fn release(&self, index: usize) {
        if let Some(buffer) = self.buffers.get(index) {
            buffer.used.store(false, Ordering::Release);
        }
    }
}
