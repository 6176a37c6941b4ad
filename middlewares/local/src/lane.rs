//! The unread samples of one queue or ring reader, by index of their buffers.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use genom_kit::index_ring::IndexRing;

/// One reader's unread samples. Lanes are never freed before the exchange, so that the writer
/// walks their list without locks; a closed one is used again.
#[derive(Debug)]
pub(crate) struct Lane {
    pub(crate) ring: IndexRing,
    /// Whether a full lane gives up its oldest sample, or refuses the new one.
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

    /// Adds a buffer; gives back the one that is lost by it, be it this one or an older one.
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
    /// Every lane, open or not.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &Arc<Lane>> {
        std::iter::successors(self.first.get(), |lane| lane.next.get())
    }

    /// A closed lane of this kind, or a new one. Called by one thread at a time.
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
