//! What the writer of a port shares with the upkeep thread: its ends, and who reads them.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use genom_middleware::{Address, OpenError};
use genom_types::DataType;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;

use crate::ground::{Ground, Shape};
use crate::queue;
use crate::raw::{self, RawPublisher, RawService, SendError, Stamp, Value};
use crate::room::Written;
use crate::typing::{Wire, wire};

/// What the writer shares with the upkeep thread.
pub(crate) struct Core {
    /// Set by the upkeep thread when a reader wants a queue.
    queue: OnceLock<RawPublisher>,
    pub(crate) publisher: RawPublisher,
    service: RawService,
    ground: Arc<Ground>,
    pub(crate) at: Address,
    pub(crate) ty: DataType,
    pub(crate) wire: Wire,
    shape: Shape,
    /// Which readers were there when connections were last made.
    readers: AtomicU64,
}

impl Core {
    /// The writing end of a port.
    pub(crate) fn open(
        ground: &Arc<Ground>,
        at: &Address,
        ty: &DataType,
    ) -> Result<Self, OpenError> {
        let wire = wire(ty);
        let shape = ground.port(&wire);
        let service = ground.service(at, &at.to_string(), ty, shape)?;
        if service.static_config().history_size() == 0 {
            tracing::warn!(port = %at, "the peer that made this port keeps no last value: readers that come late wait for the next one");
        }
        let publisher = match ground.writer(at, &service, &wire) {
            // The writer may be one that was killed.
            Err(OpenError::Taken { .. }) if ground.node.try_cleanup_dead_nodes().cleanups > 0 => {
                ground.writer(at, &service, &wire)?
            }
            other => other?,
        };
        Ok(Self {
            queue: OnceLock::new(),
            publisher,
            service,
            ground: Arc::clone(ground),
            at: at.clone(),
            ty: ty.clone(),
            wire,
            shape,
            readers: AtomicU64::new(0),
        })
    }

    pub(crate) fn is_at(&self, at: &Address) -> bool {
        self.at == *at
    }

    /// Connects readers that came since the last time, and joins their queue.
    pub(crate) fn upkeep(&self) {
        let mut readers = 0u64;
        self.service.dynamic_config().list_subscribers(|reader| {
            let id = reader.subscriber_id.value();
            readers = readers.rotate_left(7) ^ (id as u64) ^ ((id >> 64) as u64);
            CallbackProgression::Continue
        });
        if self.readers.swap(readers, Ordering::Relaxed) == readers {
            return;
        }
        if let Err(error) = self.publisher.update_connections() {
            tracing::warn!(port = %self.at, ?error, "cannot connect a reader");
        }
        if self.queue.get().is_none() && queue::wanted(&self.service) {
            match queue::join(&self.ground, &self.at, &self.ty, &self.wire, self.shape) {
                Ok(publisher) => drop(self.queue.set(publisher)),
                Err(error) => tracing::warn!(port = %self.at, %error, "cannot join a queue"),
            }
        }
    }

    /// Sends a sample to all readers; `written` remembers what has its memory.
    pub(crate) fn send(
        &self,
        value: Value<'_>,
        stamp: Stamp,
        written: &mut Written,
    ) -> Result<(), SendError> {
        // The queue first: a reader that sees a sample on the port knows that the queue has it,
        // or refused it.
        let queued = match self.queue.get() {
            Some(queue) => raw::send(queue, &self.wire, value, stamp, written),
            None => Ok(()),
        };
        raw::send(&self.publisher, &self.wire, value, stamp, written).and(queued)
    }
}
