//! State that the writer of a port shares with the upkeep thread: its ends, and who reads them.
//!
//! A port without readers has a service, so that readers of any make find it, but no publisher,
//! which would cost file descriptors and memory. Its last value is parked
//! ([`parked`](crate::parked)). When a reader appears, the upkeep thread creates the publisher,
//! which connects the reader, sends it the value, and opens the gate: from then on the writer sends
//! directly. At any time only one of the two may send, and neither waits for the other.

use std::sync::atomic::{AtomicBool, AtomicU8, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};

use genom_middleware::{Address, OpenError};
use genom_types::DataType;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;

use crate::catalog::{Kind, Offer};
use crate::ground::{Ground, Shape};
use crate::parked::Parked;
use crate::queue;
use crate::raw::{self, RawPublisher, RawService, SendError, Stamp, Value};
use crate::room::Written;
use crate::typing::{Wire, wire};

/// Gate: the writer parked a value that the upkeep thread may not have seen.
const FRESH: u8 = 1;
/// Gate: the writer sends directly.
const OPEN: u8 = 2;

/// State that the writer shares with the upkeep thread.
pub(crate) struct Core {
    /// Set by the upkeep thread when a reader with policy `queue` appears.
    queue: OnceLock<RawPublisher>,
    /// Set by the upkeep thread when a reader appears.
    out: OnceLock<Out>,
    gate: AtomicU8,
    parked: Parked,
    /// Number of values parked so far.
    rank: AtomicU64,
    /// Rank of the last parked value that the upkeep thread sent.
    sent_parked: AtomicU64,
    /// Number of samples sent so far.
    sent: AtomicU64,
    service: Arc<RawService>,
    ground: Arc<Ground>,
    pub(crate) at: Address,
    pub(crate) ty: DataType,
    pub(crate) wire: Wire,
    shape: Shape,
    /// Which readers existed when connections were last made.
    readers: AtomicU64,
    /// How many there were when it was last looked which.
    number: AtomicUsize,
    /// Whether the last reader could not be connected; reported once.
    failing: AtomicBool,
}

/// The publisher, and the id in the stamps of its samples.
struct Out {
    publisher: RawPublisher,
    writer: u32,
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
        let writers = || service.dynamic_config().number_of_publishers();
        // The existing writer may have been killed.
        if writers() > 0 {
            let _ = ground.watcher.heal_dead();
            if writers() > 0 {
                return Err(OpenError::Taken { address: at.clone() });
            }
        }
        let offer = Offer { digests: ty.digest().to_owned(), spelling: ty.name().to_owned() };
        ground.offer(Kind::Writer, at, offer)?;
        Ok(Self {
            queue: OnceLock::new(),
            out: OnceLock::new(),
            gate: AtomicU8::new(0),
            parked: Parked::new((!wire.slice).then_some(wire.size)),
            rank: AtomicU64::new(0),
            sent_parked: AtomicU64::new(0),
            sent: AtomicU64::new(0),
            service,
            ground: Arc::clone(ground),
            at: at.clone(),
            ty: ty.clone(),
            wire,
            shape,
            readers: AtomicU64::new(0),
            number: AtomicUsize::new(0),
            failing: AtomicBool::new(false),
        })
    }

    pub(crate) fn is_at(&self, at: &Address) -> bool {
        self.at == *at
    }

    /// Size in bytes of the values, if all have the same.
    pub(crate) fn size(&self) -> Option<usize> {
        (!self.wire.slice).then_some(self.wire.size)
    }

    /// Connects readers that appeared since the last call, and joins their queue. If not `closely`,
    /// only a number of readers that changed is seen, which costs less. Called by one thread
    /// at a time.
    pub(crate) fn upkeep(&self, closely: bool) -> Result<(), OpenError> {
        let number = self.service.dynamic_config().number_of_subscribers();
        if self.number.swap(number, Ordering::Relaxed) == number && !closely {
            return Ok(());
        }
        let mut readers = 0u64;
        self.service.dynamic_config().list_subscribers(|reader| {
            let id = reader.subscriber_id.value();
            readers = readers.rotate_left(7) ^ (id as u64) ^ ((id >> 64) as u64);
            CallbackProgression::Continue
        });
        if self.readers.swap(readers, Ordering::Relaxed) == readers {
            return Ok(());
        }
        let connected = self.connect(readers != 0);
        match &connected {
            Ok(()) => self.failing.store(false, Ordering::Relaxed),
            Err(error) => {
                // So that it is tried again next time.
                self.readers.store(0, Ordering::Relaxed);
                self.number.store(usize::MAX, Ordering::Relaxed);
                if !self.failing.swap(true, Ordering::Relaxed) {
                    tracing::warn!(port = %self.at, %error, "cannot connect a reader");
                }
            }
        }
        connected
    }

    fn connect(&self, any: bool) -> Result<(), OpenError> {
        if self.queue.get().is_none() && queue::wanted(&self.service) {
            let queue = queue::join(&self.ground, &self.at, &self.ty, &self.wire, self.shape)?;
            drop(self.queue.set(queue));
        }
        match self.out.get() {
            Some(out) => {
                if let Err(error) = out.publisher.update_connections() {
                    tracing::warn!(port = %self.at, ?error, "cannot connect a reader");
                }
                Ok(())
            }
            None if any => self.open_gate(),
            None => Ok(()),
        }
    }

    /// Creates the publisher, and lets the writer send.
    fn open_gate(&self) -> Result<(), OpenError> {
        // Creating it connects all readers.
        let publisher = self.ground.writer(&self.at, &self.service, &self.wire)?;
        let writer = raw::short(publisher.id().value());
        drop(self.out.set(Out { publisher, writer }));
        let mut written = Written::new(self.size(), self.ground.options.keep_free);
        let mut rank = 0;
        loop {
            self.gate.fetch_and(!FRESH, Ordering::AcqRel);
            rank = self.parked.newest(rank, |bytes| {
                let value =
                    if self.wire.slice { Value::Encoded(bytes) } else { Value::Plain(bytes) };
                if let Err(error) = self.send_now(value, &mut written) {
                    tracing::warn!(port = %self.at, ?error, "a reader that came late does not see its last value");
                }
            });
            self.sent_parked.store(rank, Ordering::Relaxed);
            let open = self.gate.compare_exchange(0, OPEN, Ordering::AcqRel, Ordering::Acquire);
            if open.is_ok() {
                break;
            }
        }
        self.parked.forget();
        Ok(())
    }

    /// Sends a sample to all readers, or parks it while there are none. `written` remembers which
    /// samples have memory. Called by one thread at a time.
    pub(crate) fn send(&self, value: Value<'_>, written: &mut Written) -> Result<(), SendError> {
        if self.gate.load(Ordering::Acquire) & OPEN == 0 {
            let rank = self.rank.fetch_add(1, Ordering::Relaxed) + 1;
            let parked = self.parked.park(value, rank);
            // If the gate is opened after this, whoever opens it has seen the value.
            if self.gate.fetch_or(FRESH, Ordering::AcqRel) & OPEN == 0 {
                return parked;
            }
            // The gate was opened meanwhile. Either the parked value was sent then, or it was
            // parked too late for that and is sent here.
            if self.sent_parked.load(Ordering::Relaxed) == rank {
                return Ok(());
            }
        }
        self.send_now(value, written)
    }

    fn send_now(&self, value: Value<'_>, written: &mut Written) -> Result<(), SendError> {
        let Some(out) = self.out.get() else { return Err(SendError::Refused) };
        let number = self.sent.load(Ordering::Relaxed) + 1;
        let stamp = Stamp { writer: out.writer, number };
        // The queue first: a reader that sees a sample on the port can rely on the queue having
        // stored or refused it.
        let queued = match self.queue.get() {
            Some(queue) => raw::send(queue, &self.wire, value, stamp, written),
            None => Ok(()),
        };
        let sent = raw::send(&out.publisher, &self.wire, value, stamp, written).and(queued);
        // A value that cannot be encoded is not a sample that a reader could miss.
        if sent != Err(SendError::Serialization) {
            self.sent.store(number, Ordering::Relaxed);
        }
        sent
    }
}

impl Drop for Core {
    fn drop(&mut self) {
        // Dropped before the address is freed, so that the next writer finds no publisher there.
        drop((self.out.take(), self.queue.take()));
        self.ground.withdraw(Kind::Writer, &self.at);
    }
}
