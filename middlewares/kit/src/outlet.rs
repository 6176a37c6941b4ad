//! The codel's end of an out port on a middleware that sends encoded samples.

use std::sync::atomic::{AtomicU64, Ordering};

use genom_middleware::PublishError;
use genom_types::{DataType, Record};

use crate::mailbox::{Full, Mailbox, PutError};
use crate::spares::{Message, Spares};

/// Samples on their way from a codel to a sending thread. The newest get through: when the thread
/// does not keep up, the oldest give way, and are counted.
#[derive(Debug)]
pub struct Outlet {
    ty: DataType,
    mailbox: Mailbox,
    spares: Spares,
    /// Samples that the middleware refused.
    refused: AtomicU64,
}

impl Outlet {
    /// Holds at most `depth` samples, each in a buffer made ready for `room` bytes.
    #[must_use]
    pub fn new(ty: &DataType, depth: usize, room: usize) -> Self {
        // The plan of the encoding is made here, and not by the first write.
        ty.prepare();
        Self {
            ty: ty.clone(),
            mailbox: Mailbox::new(depth, room, Full::Oldest),
            spares: Spares::new(room),
            refused: AtomicU64::new(0),
        }
    }

    /// Encodes a sample. Wait-free; nothing is allocated when the buffers are large enough.
    ///
    /// # Errors
    /// The value is of another type, or has no encoding.
    pub fn put(&self, value: &Record) -> Result<(), PublishError> {
        if !value.ty().same_as(&self.ty) {
            return Err(PublishError::Refused);
        }
        self.mailbox.put(|message| value.encode_message(message)).map_err(|error| match error {
            PutError::Fill(_) => PublishError::Serialization,
            PutError::Busy => PublishError::Refused,
        })
    }

    /// Takes the oldest sample, for the sending thread.
    #[must_use]
    pub fn take(&self) -> Option<Message> {
        self.spares.take(&self.mailbox)
    }

    /// The middleware did not send a sample that was taken.
    pub fn refuse(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }

    /// Samples that gave way or were refused.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.mailbox.lost() + self.refused.load(Ordering::Relaxed)
    }
}
