//! The unread samples of one queue or ring reader, as indices of their buffers.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use genom_kit::index_ring::IndexRing;

/// The unread samples of one reader. A lane is never freed before the exchange, so that the writer
/// can walk the list without a lock; a closed lane is reused.
#[derive(Debug)]
pub(crate) struct Lane {
    pub(crate) ring: IndexRing,
    /// When full: true drops the oldest sample, false the new one.
    pub(crate) overwrites: bool,
    /// Whether it has a reader.
    pub(crate) open: AtomicBool,
    pub(crate) dropped: AtomicU64,
    next: OnceLock<Arc<Lane>>,
}

impl Lane {
    fn new(capacity: usize, overwrites: bool) -> Self {
        Self {
            ring: IndexRing::new(capacity),
            overwrites,
            open: AtomicBool::new(false),
            dropped: AtomicU64::new(0),
            next: OnceLock::new(),
        }
    }

    /// Pushes a buffer. Returns the one that is dropped for it: the oldest, or the new one itself.
    pub(crate) fn push(&self, index: usize) -> Option<usize> {
        let lost = if self.overwrites {
            self.ring.push_over(index)
        } else {
            (!self.ring.push_if_free(index)).then_some(index)
        };
        if lost.is_some() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
        lost
    }
}

/// All lanes of an exchange, in order of creation.
#[derive(Debug, Default)]
pub(crate) struct Lanes {
    first: OnceLock<Arc<Lane>>,
}

impl Lanes {
    /// Every lane, open or closed.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Arc<Lane>> {
        std::iter::successors(self.first.get(), |lane| lane.next.get())
    }

    /// Reuses a closed lane of this kind, or creates one. Called by one thread at a time.
    pub(crate) fn take(&self, capacity: usize, overwrites: bool) -> Arc<Lane> {
        let mut end = &self.first;
        while let Some(lane) = end.get() {
            let fits = lane.ring.capacity() == capacity && lane.overwrites == overwrites;
            if fits && !lane.open.load(Ordering::SeqCst) {
                return Arc::clone(lane);
            }
            end = &lane.next;
        }
        Arc::clone(end.get_or_init(|| Arc::new(Lane::new(capacity, overwrites))))
    }
}
