//! Buffers that pass from a mailbox to a middleware without a copy, and are reused.
//!
//! Taking a message out of a mailbox leaves a spare buffer in its place. When the middleware drops
//! the message, its buffer becomes the next spare. Real-time threads are not involved.

use std::sync::{Arc, Mutex, PoisonError};

use crate::mailbox::Mailbox;

/// Number of spare buffers kept; more are freed.
const KEPT: usize = 8;

/// The spare buffers of one mailbox. Clones share them.
#[derive(Clone, Debug)]
pub struct Spares {
    buffers: Arc<Mutex<Vec<Vec<u8>>>>,
    /// Initial size in bytes of a new buffer.
    size: usize,
}

/// A message taken from a mailbox. Dropping it makes its buffer a spare.
#[derive(Debug)]
pub struct Message {
    bytes: Vec<u8>,
    home: Spares,
}

impl Spares {
    /// No spares yet. New buffers are allocated with `size` bytes.
    #[must_use]
    pub fn new(size: usize) -> Self {
        Self { buffers: Arc::default(), size }
    }

    /// Takes the oldest message of the mailbox, if there is one. For the mailbox's consumer.
    #[must_use]
    pub fn take(&self, mailbox: &Mailbox) -> Option<Message> {
        let mut bytes = self.spare();
        let taken = mailbox.exchange(&mut bytes);
        // If there was no message, this holds the unused spare, which is returned on drop.
        let message = Message { bytes, home: self.clone() };
        taken.then_some(message)
    }

    fn spare(&self) -> Vec<u8> {
        let spare = self.buffers.lock().unwrap_or_else(PoisonError::into_inner).pop();
        spare.unwrap_or_else(|| Vec::with_capacity(self.size))
    }
}

impl AsRef<[u8]> for Message {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

impl Drop for Message {
    fn drop(&mut self) {
        let mut buffers = self.home.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        if buffers.len() < KEPT {
            buffers.push(std::mem::take(&mut self.bytes));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::mailbox::Full;

    fn put(mailbox: &Mailbox, bytes: &[u8]) {
        let put = mailbox.put(|message| {
            message.extend_from_slice(bytes);
            Ok::<_, Infallible>(())
        });
        assert!(put.is_ok());
    }

    #[test]
    fn messages_leave_in_order_and_their_buffers_come_back() {
        let (mailbox, spares) = (Mailbox::new(2, 16, Full::Oldest), Spares::new(16));
        assert!(spares.take(&mailbox).is_none());
        assert_eq!(spares.buffers.lock().unwrap().len(), 1, "the spare one was not needed");
        put(&mailbox, b"one");
        put(&mailbox, b"two");
        let [one, two] = [(); 2].map(|()| spares.take(&mailbox).unwrap());
        assert_eq!((one.as_ref(), two.as_ref()), (&b"one"[..], &b"two"[..]));
        let places = [one.as_ref().as_ptr(), two.as_ref().as_ptr()];
        drop((one, two));
        // From the second round on, the same buffers are reused.
        for round in 0..20u8 {
            put(&mailbox, &[round; 16]);
            let message = spares.take(&mailbox).unwrap();
            assert_eq!(message.as_ref(), [round; 16]);
        }
        let kept = spares.buffers.lock().unwrap();
        assert!(kept.iter().all(|buffer| buffer.capacity() >= 16));
        assert!(kept.len() <= 3 && kept.iter().any(|buffer| places.contains(&buffer.as_ptr())));
    }

    #[test]
    fn a_message_may_outlive_its_mailbox() {
        let (mailbox, spares) = (Mailbox::new(1, 4, Full::Oldest), Spares::new(4));
        put(&mailbox, b"last");
        let message = spares.take(&mailbox).unwrap();
        drop((mailbox, spares));
        assert_eq!(message.as_ref(), b"last");
    }
}
