//! The writing end of a port.

use std::sync::Arc;

use genom_middleware::{Address, OpenError, PublishError, Publisher};
use genom_types::{DataType, Record};

use crate::inner::Inner;
use crate::raw::{SendError, Value};
use crate::room::{WAY_OUT, Written};
use crate::writer::Core;

/// The writer. Dropping it first removes the core from the upkeep thread.
struct ShmPublisher {
    core: Arc<Core>,
    inner: Arc<Inner>,
    dropped: u64,
    written: Written,
    /// Whether the last sample found no memory; reported once.
    full: bool,
}

/// Opens the writing end of a port.
pub(crate) fn open(
    inner: &Arc<Inner>,
    at: &Address,
    ty: &DataType,
) -> Result<impl Publisher + 'static, OpenError> {
    let core = Arc::new(Core::open(&inner.ground, at, ty)?);
    core.upkeep(true)?;
    inner.upkeep.add(&core);
    let written = Written::new(core.size(), inner.ground.options.keep_free);
    Ok(ShmPublisher { core, inner: Arc::clone(inner), dropped: 0, written, full: false })
}

impl Publisher for ShmPublisher {
    fn publish(&mut self, value: &Record) -> Result<(), PublishError> {
        if !value.ty().same_as(&self.core.ty) {
            return Err(PublishError::Refused);
        }
        let value = match value.bytes() {
            Some(bytes) => Value::Plain(bytes),
            None => Value::Message(value, value.message_size()),
        };
        let sent = self.core.send(value, &mut self.written);
        let full = sent == Err(SendError::NoRoom);
        if full && !self.full {
            tracing::warn!(port = %self.core.at, "no shared memory is left for its samples: {WAY_OUT}");
        }
        self.full = full;
        match sent {
            Ok(()) => Ok(()),
            Err(SendError::Full) => {
                self.dropped += 1;
                Ok(())
            }
            Err(SendError::Serialization) => Err(PublishError::Serialization),
            Err(SendError::NoRoom | SendError::Refused) => Err(PublishError::Refused),
        }
    }

    fn dropped(&self) -> u64 {
        self.dropped
    }
}

impl Drop for ShmPublisher {
    fn drop(&mut self) {
        self.inner.upkeep.remove(&self.core);
    }
}
