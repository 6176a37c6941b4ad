//! Unread samples of one in port.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use genom_kit::intake::Keeping;
use genom_kit::mailbox::Mailbox;
use zenoh::bytes::ZBytes;
use zenoh::shm::ShmBuf;

/// A message that all in ports of a topic share without copying it.
pub(crate) type Message = Arc<Vec<u8>>;

/// A message that waits.
#[derive(Debug)]
pub(crate) enum Waiting {
    Copied(Message),
    /// Contiguous, in the memory in which zenoh received it.
    Held(ZBytes),
}

impl Waiting {
    /// Passes the message to `decode`. Returns false if that does.
    pub(crate) fn read(&self, decode: impl FnOnce(&[u8]) -> bool) -> bool {
        match self {
            Self::Copied(message) => decode(message),
            Self::Held(bytes) => {
                let message = bytes.slices().next().unwrap_or_default();
                is_whole(bytes) && decode(message) && is_whole(bytes)
            }
        }
    }
}

/// Whether shared memory is still valid: zenoh returns it to the writer if this process was stopped
/// for so long that it seemed dead.
fn is_whole(bytes: &ZBytes) -> bool {
    bytes.as_shm().is_none_or(|shm| shm.is_valid())
}

/// Unread samples of one in port.
#[derive(Debug)]
pub(crate) struct Inbox {
    pub(crate) mailbox: Mailbox<Waiting>,
    keeping: Keeping,
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
    pub(crate) fn new(keeping: Keeping) -> Self {
        let Keeping { depth, full, .. } = keeping;
        let nothing = || Waiting::Copied(Message::default());
        Self {
            mailbox: Mailbox::with(depth, full, nothing).dated(),
            keeping,
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
            if self.keeping.counts { self.mailbox.lost() + count(&self.missing) } else { 0 };
        given_up + count(&self.undecodable) + count(&self.refused)
    }

    /// Adds a message. Returns the copy that it overwrites.
    pub(crate) fn put(&self, message: &Message) -> Option<Message> {
        self.add(Waiting::Copied(Arc::clone(message)))
    }

    /// Adds a message without a copy of it, if it may wait where it was received and is in one
    /// piece. Returns whether it did, and the copy that it overwrites.
    pub(crate) fn hold(&self, payload: &ZBytes) -> (bool, Option<Message>) {
        let held = self.keeping.holds(payload.len()) && payload.slices().nth(1).is_none();
        (held, if held { self.add(Waiting::Held(payload.clone())) } else { None })
    }

    fn add(&self, message: Waiting) -> Option<Message> {
        let exchange = |place: &mut Waiting| {
            Ok::<_, std::convert::Infallible>(std::mem::replace(place, message))
        };
        let old = self.mailbox.put_by(exchange).ok();
        if old.is_none() {
            self.undecodable.fetch_add(1, Ordering::Relaxed);
        }
        if let Some(told) = self.told.0.get() {
            told();
        }
        old.and_then(|old| match old {
            Waiting::Copied(copy) => Some(copy),
            Waiting::Held(_) => None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_kit::mailbox::Full;

    fn read(inbox: &Inbox) -> Option<Vec<u8>> {
        let mut bytes = None;
        let mut keep = |message: &[u8]| {
            bytes = Some(message.to_vec());
            true
        };
        inbox.mailbox.take(|message| message.read(&mut keep))?.then_some(())?;
        bytes
    }

    #[test]
    fn what_is_held_and_what_is_copied_reads_alike() {
        let inbox = |counts| Inbox::new(Keeping { depth: 2, full: Full::Oldest, counts });
        let (latest, ring) = (inbox(false), inbox(true));
        let payload = ZBytes::from(vec![7; 64 << 10]);
        assert!(latest.hold(&payload).0);
        assert_eq!(read(&latest), Some(vec![7; 64 << 10]));
        assert!(!ring.hold(&payload).0, "a ring may have many");
        assert!(!latest.hold(&ZBytes::from("short")).0);
        let mut pieces = ZBytes::writer();
        pieces.append(ZBytes::from(vec![1; 16 << 10]));
        pieces.append(ZBytes::from(vec![2; 16 << 10]));
        assert!(!latest.hold(&pieces.finish()).0, "it is in pieces");
        ring.put(&Arc::new(vec![1, 2]));
        assert_eq!((read(&ring), read(&ring)), (Some(vec![1, 2]), None));
    }
}
