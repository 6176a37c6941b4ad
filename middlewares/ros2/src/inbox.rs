//! Unread samples of one in port.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use genom_kit::intake::Keeping;
use genom_kit::mailbox::Mailbox;

/// A message that all in ports of a topic share without copying it.
pub(crate) type Message = Arc<Vec<u8>>;

/// Unread samples of one in port.
#[derive(Debug)]
pub(crate) struct Inbox {
    pub(crate) mailbox: Mailbox<Message>,
    /// Whether overwritten samples are losses; false for policy `latest`.
    counts_lost: bool,
    /// Number of samples that could not be decoded.
    pub(crate) undecodable: AtomicU64,
    /// Number of samples of another type.
    pub(crate) refused: AtomicU64,
    /// Number of samples that never arrived.
    pub(crate) missing: AtomicU64,
    /// Told of each arrival.
    pub(crate) told: Told,
}

/// Who is told of arrivals, if anybody wants to be.
#[derive(Default)]
pub(crate) struct Told(pub(crate) OnceLock<Box<dyn Fn() + Send + Sync>>);

impl std::fmt::Debug for Told {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Told").field(&self.0.get().is_some()).finish()
    }
}

impl Inbox {
    pub(crate) fn new(Keeping { depth, full, counts }: Keeping) -> Self {
        Self {
            mailbox: Mailbox::with(depth, full, Message::default).dated(),
            counts_lost: counts,
            undecodable: AtomicU64::new(0),
            refused: AtomicU64::new(0),
            missing: AtomicU64::new(0),
            told: Told::default(),
        }
    }

    /// Number of samples lost to the reader.
    pub(crate) fn lost(&self) -> u64 {
        let count = |lost: &AtomicU64| lost.load(Ordering::Relaxed);
        let given_up =
            if self.counts_lost { self.mailbox.lost() + count(&self.missing) } else { 0 };
        given_up + count(&self.undecodable) + count(&self.refused)
    }

    /// Adds a message. Returns the one that it overwrites.
    pub(crate) fn put(&self, message: &Message) -> Option<Message> {
        let exchange = |place: &mut Message| {
            Ok::<_, std::convert::Infallible>(std::mem::replace(place, Arc::clone(message)))
        };
        let old = self.mailbox.put_by(exchange).ok();
        if old.is_none() {
            self.undecodable.fetch_add(1, Ordering::Relaxed);
        }
        if let Some(told) = self.told.0.get() {
            told();
        }
        old
    }
}
