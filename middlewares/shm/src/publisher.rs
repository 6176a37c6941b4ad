//! The writing end of a port.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use genom_middleware::{Address, OpenError, PublishError, Publisher};
use genom_types::{DataType, Record};
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;

use crate::backend::{Ground, Inner, Shape, failed};
use crate::options::Options;
use crate::queue;
use crate::raw::{self, RawPublisher, RawService, SendError, Stamp, Value};
use crate::room::{WAY_OUT, Written};
use crate::typing::{Wire, wire};

/// First room for values of variable size; it doubles as needed.
const FIRST_ROOM: usize = 1024;

/// Memory for samples that is made beforehand, beyond what is needed in any case.
const SAMPLE_BYTES: usize = 4 << 20;

/// What the writer shares with the upkeep thread.
pub(crate) struct Core {
    /// Set by the upkeep thread when a reader wants a queue.
    queue: OnceLock<RawPublisher>,
    publisher: RawPublisher,
    service: RawService,
    ground: Arc<Ground>,
    at: Address,
    ty: DataType,
    wire: Wire,
    shape: Shape,
    /// Which readers were there when connections were last made.
    readers: AtomicU64,
}

/// The writer. Its drop takes the core from the upkeep thread first.
struct ShmPublisher {
    core: Arc<Core>,
    inner: Arc<Inner>,
    /// Stamp of the next sample.
    next: Stamp,
    dropped: u64,
    written: Written,
    /// Whether the last sample found no room: told once.
    full: bool,
}

/// Opens the writing end of a port.
pub(crate) fn open(
    inner: &Arc<Inner>,
    at: &Address,
    ty: &DataType,
) -> Result<impl Publisher + 'static, OpenError> {
    let (ground, wire) = (&inner.ground, wire(ty));
    let shape = ground.port(&wire);
    let service = ground.service(at, &at.to_string(), ty, shape)?;
    if service.static_config().history_size() == 0 {
        tracing::warn!(port = %at, "the peer that made this port keeps no last value: readers that come late wait for the next one");
    }
    let publisher = match create(&ground.options, at, &service, &wire) {
        // The writer may be one that was killed.
        Err(OpenError::Taken { .. }) if ground.node.try_cleanup_dead_nodes().cleanups > 0 => {
            create(&ground.options, at, &service, &wire)?
        }
        other => other?,
    };
    let core = Arc::new(Core {
        queue: OnceLock::new(),
        publisher,
        service,
        ground: Arc::clone(ground),
        at: at.clone(),
        ty: ty.clone(),
        wire,
        shape,
        readers: AtomicU64::new(0),
    });
    core.upkeep();
    inner.upkeep.add(&core);
    let id = core.publisher.id().value();
    let next = Stamp { writer: (id ^ (id >> 32) ^ (id >> 64) ^ (id >> 96)) as u32, number: 1 };
    let size = (!core.wire.slice).then_some(core.wire.size);
    let written = Written::new(size, ground.options.keep_free);
    Ok(ShmPublisher { core, inner: Arc::clone(inner), next, dropped: 0, written, full: false })
}

/// A writer's end of a service, the only one it has.
pub(crate) fn create(
    options: &Options,
    at: &Address,
    service: &RawService,
    wire: &Wire,
) -> Result<RawPublisher, OpenError> {
    let taken = || OpenError::Taken { address: at.clone() };
    if service.dynamic_config().number_of_publishers() > 0 {
        return Err(taken());
    }
    // Enough for one reader that never reads, one sample in each other's hand, the last value
    // and the one being written; for small types, enough for all readers that never read.
    let depth = service.static_config().subscriber_max_buffer_size();
    let needed = depth + options.readers + 4;
    let affordable = SAMPLE_BYTES / if wire.slice { FIRST_ROOM } else { wire.size.max(64) };
    let limit = if wire.slice { needed } else { needed.max(affordable) };
    let builder = service
        .publisher_builder()
        .max_loaned_samples(1)
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .override_sample_preallocation(move |worst| worst.min(limit));
    let builder = if wire.slice {
        builder
            .initial_max_slice_len(FIRST_ROOM)
            .allocation_strategy(AllocationStrategy::PowerOfTwo)
    } else {
        builder
    };
    builder.create().map_err(|error| match error {
        PublisherCreateError::ExceedsMaxSupportedPublishers => taken(),
        other => failed(at, &other.to_string()),
    })
}

impl Core {
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

    fn send(&self, value: Value<'_>, stamp: Stamp, written: &mut Written) -> Result<(), SendError> {
        // The queue first: a reader that sees a sample on the port knows that the queue has it,
        // or refused it.
        let queued = match self.queue.get() {
            Some(queue) => raw::send(queue, &self.wire, value, stamp, written),
            None => Ok(()),
        };
        raw::send(&self.publisher, &self.wire, value, stamp, written).and(queued)
    }
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
        let sent = self.core.send(value, self.next, &mut self.written);
        let full = sent == Err(SendError::NoRoom);
        if full && !self.full {
            tracing::warn!(port = %self.core.at, "no shared memory is left for its samples: {WAY_OUT}");
        }
        self.full = full;
        // What cannot be encoded is no sample that a reader could miss.
        if sent != Err(SendError::Serialization) {
            self.next.number += 1;
        }
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
