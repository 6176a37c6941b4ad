//! The writing end of a port, on middlewares that send encoded samples.

use std::convert::Infallible;
use std::sync::atomic::{AtomicU64, Ordering};

use genom_middleware::PublishError;
use genom_types::{DataType, Record};

use crate::mailbox::{Full, Mailbox, PutError};
use crate::spares::{Message, Spares};

/// Size of a buffer for messages of the type that avoids later allocation as far as possible: CDR is
/// seldom larger than the C layout, and never four times as large.
#[must_use]
pub fn room_of(ty: &DataType) -> usize {
    let size = ty.size();
    if size <= 1 << 16 { size * 4 + 64 } else { size + size / 4 }
}

/// Samples on their way from a codel to a sending thread. If the thread cannot keep up, the oldest
/// samples are dropped and counted.
///
/// ```
/// use std::sync::Arc;
/// use genom_kit::outlet::Outlet;
/// use genom_types::{DataType, Kind, Record, TypeTable};
///
/// let mut types = TypeTable::default();
/// let double = types.add(Kind::Double);
/// let ty = DataType::new(&Arc::new(types), double)?;
/// let outlet = Outlet::new(&ty, 2, 64); // two samples, buffers of 64 bytes
/// for _ in 0..3 {
///     outlet.put(&Record::new(&ty))?;
/// }
/// assert_eq!(outlet.dropped(), 1);
/// let sample = outlet.take().expect("two samples are left");
/// let bytes: &[u8] = sample.as_ref();
/// assert_eq!(bytes.len(), 4 + 8); // encapsulation header and a double
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Outlet {
    ty: DataType,
    mailbox: Mailbox,
    spares: Spares,
    /// Number of samples that the middleware refused.
    refused: AtomicU64,
}

impl Outlet {
    /// An outlet for at most `depth` samples, in buffers that are allocated with `room` bytes each.
    #[must_use]
    pub fn new(ty: &DataType, depth: usize, room: usize) -> Self {
        // Compile the encoding plan now, so that the first write need not.
        ty.prepare();
        Self {
            ty: ty.clone(),
            mailbox: Mailbox::new(depth, room, Full::Oldest),
            spares: Spares::new(room),
            refused: AtomicU64::new(0),
        }
    }

    /// Encodes a sample and queues it. Wait-free; allocates nothing if the buffers are large
    /// enough.
    ///
    /// # Errors
    /// The value has another type, or cannot be encoded.
    pub fn put(&self, value: &Record) -> Result<(), PublishError> {
        if !value.ty().same_as(&self.ty) {
            return Err(PublishError::Refused);
        }
        self.mailbox.put(|message| value.encode_message(message)).map_err(|error| match error {
            PutError::Fill(_) => PublishError::Serialization,
            PutError::Busy => PublishError::Refused,
        })
    }

    /// Queues a sample that is encoded already.
    ///
    /// # Errors
    /// It is no value of the type.
    pub fn put_message(&self, message: &[u8]) -> Result<(), PublishError> {
        let size = self.ty.check_message(message).map_err(|_| PublishError::Serialization)?;
        let message = message.get(..size).unwrap_or(message);
        let put = self.mailbox.put(|buffer| {
            buffer.extend_from_slice(message);
            Ok::<_, Infallible>(())
        });
        put.map_err(|_| PublishError::Refused)
    }

    /// Takes the oldest sample. For the sending thread.
    #[must_use]
    pub fn take(&self) -> Option<Message> {
        self.spares.take(&self.mailbox)
    }

    /// Counts a taken sample that the middleware refused to send.
    pub fn refuse(&self) {
        self.refused.fetch_add(1, Ordering::Relaxed);
    }

    /// Number of samples dropped or refused so far.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.mailbox.lost() + self.refused.load(Ordering::Relaxed)
    }
}
