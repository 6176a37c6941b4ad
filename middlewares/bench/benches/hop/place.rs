//! Where a middleware's own thread leaves what arrived, for the reader to see.

use std::hint::black_box;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

use genom_bench::pair::Receive;

#[derive(Default)]
pub(crate) struct Place {
    count: AtomicU64,
    bytes: Mutex<Vec<u8>>,
}

/// The reader's end; `K` is what keeps values coming.
pub(crate) struct Looks<K> {
    pub(crate) place: Arc<Place>,
    pub(crate) seen: u64,
    pub(crate) _keep: K,
}

impl Place {
    pub(crate) fn put<'a>(&self, parts: impl Iterator<Item = &'a [u8]>) {
        let mut bytes = self.bytes.lock().unwrap();
        bytes.clear();
        parts.for_each(|part| bytes.extend_from_slice(part));
        drop(bytes);
        self.count.fetch_add(1, Ordering::Release);
    }
}

impl<K> Receive for Looks<K> {
    fn arrived(&mut self) -> bool {
        let count = self.place.count.load(Ordering::Acquire);
        let new = count != self.seen;
        self.seen = count;
        if new {
            black_box(self.place.bytes.lock().unwrap().len());
        }
        new
    }
}
