//! The reading end of a port.

use std::sync::Arc;
use std::thread;
use std::time::Instant;

use genom_middleware::{Address, OpenError, Policy, ReadError, Reading, Subscription};
use genom_types::{DataType, Record};
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::prelude::*;

use crate::error::{BACKEND, failed};
use crate::inner::Inner;
use crate::queue::{self, Queue};
use crate::raw::{self, RawSample, RawService, RawSubscriber, Stamp};
use crate::typing::{Wire, wire};
use crate::upkeep::PERIOD;

/// The reader. Fields are dropped in order: ends of services before the node.
struct ShmSubscription {
    /// The writer's last value when this reader was opened; it is read first.
    start: Option<RawSample>,
    /// The newest sample on the port, kept until the queue is joined.
    held: Option<RawSample>,
    queue: Option<Queue>,
    subscriber: RawSubscriber,
    _service: Arc<RawService>,
    values: Values,
    /// Whether only the newest sample counts (policy `latest`).
    latest: bool,
    _inner: Arc<Inner>,
}

/// State of what was read so far.
struct Values {
    wire: Wire,
    /// Values of variable size are decoded here first, so that a failure changes nothing.
    scratch: Option<Record>,
    /// Stamp of the last sample that was read or given up.
    last: Option<Stamp>,
    /// The publisher that existed before this reader, while it is unknown which of its samples came
    /// before the reader. All samples of other publishers came after it.
    unsure: Option<u32>,
    any: bool,
    dropped: u64,
}

/// Opens the reading end of a port.
pub(crate) fn open(
    inner: &Arc<Inner>,
    at: &Address,
    ty: &DataType,
    policy: Policy,
) -> Result<impl Subscription + 'static, OpenError> {
    let (ground, wire) = (&inner.ground, wire(ty));
    let shape = ground.port(&wire);
    let service = ground.service(at, &at.to_string(), ty, shape)?;
    let most = service.static_config().subscriber_max_buffer_size();
    let (wanted, buffer) = match policy {
        Policy::Latest => (1, 1),
        Policy::Ring(depth) => (depth.max(1), depth.max(1)),
        Policy::Queue(depth) => (depth.max(1), 1),
    };
    if wanted > most {
        return Err(OpenError::Unsupported {
            backend: BACKEND.to_owned(),
            ty: ty.name().to_owned(),
            why: format!(
                "{at} was opened for at most {most} unread samples a reader (of large types, for \
                 16 MiB of them), not {wanted}: ask for {most}, or set backends.shm.depth in the \
                 configuration of the daemon that opens the port first"
            ),
        });
    }
    // Create the queue before the writer is told that one is wanted.
    let queue = match policy {
        Policy::Queue(_) => Some(Queue::new(ground, at, ty, shape, wanted)?),
        _ => None,
    };
    let mut builder = service.subscriber_builder().buffer_size(buffer);
    if let (Some(mark), true) = (queue::mark(), queue.is_some()) {
        builder = builder.name(&mark);
    }
    let before = publisher(&service);
    let subscriber = builder.create().map_err(|error| match error {
        SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
            let readers = service.static_config().max_subscribers();
            let full = format!(
                "the port was opened for at most {readers} readers, and has them: set \
                 backends.shm.readers in the configuration of the daemon that opens it first"
            );
            failed(at, &full)
        }
        other => failed(at, &other.to_string()),
    })?;
    let is_own = inner.upkeep.reader_came(at)?;
    let start = match policy {
        Policy::Latest => None,
        _ => last_value(&subscriber, before.is_none() || is_own),
    };
    let scratch = wire.slice.then(|| Record::new(ty));
    let unsure = before.filter(|_| start.is_none() && !is_own);
    Ok(ShmSubscription {
        start,
        held: None,
        queue,
        subscriber,
        _service: service,
        values: Values { wire, scratch, last: None, unsure, any: false, dropped: 0 },
        latest: policy == Policy::Latest,
        _inner: Arc::clone(inner),
    })
}

/// The last value of the writer, if it has written. The upkeep thread of another daemon connects
/// readers within one period, and sends the value then.
fn last_value(subscriber: &RawSubscriber, connected: bool) -> Option<RawSample> {
    let end = Instant::now() + 2 * PERIOD;
    loop {
        let sample = subscriber.receive().ok().flatten();
        if sample.is_some() || connected || Instant::now() > end {
            return sample;
        }
        thread::park_timeout(PERIOD / 10);
    }
}

/// The publisher of a port, as stamps identify it.
fn publisher(service: &RawService) -> Option<u32> {
    let mut found = None;
    service.dynamic_config().list_publishers(|publisher| {
        found = Some(raw::short(publisher.publisher_id.value()));
        CallbackProgression::Stop
    });
    found
}

impl Values {
    /// Compares a sample with the last one of its writer, and counts those missing in between.
    /// Returns whether it is new.
    fn is_next(&mut self, sample: &RawSample) -> bool {
        let Some(stamp) = self.stamp(sample) else { return true };
        let last = match self.last_of(stamp.writer) {
            Some(last) => last,
            None if self.unsure == Some(stamp.writer) => stamp.number.saturating_sub(1),
            None => 0,
        };
        if stamp.number <= last {
            return false;
        }
        self.dropped += stamp.number - last - 1;
        self.last = Some(stamp);
        true
    }

    fn stamp(&self, sample: &RawSample) -> Option<Stamp> {
        raw::open_sample(sample, &self.wire).1
    }

    fn last_of(&self, writer: u32) -> Option<u64> {
        self.last.and_then(|last| (last.writer == writer).then_some(last.number))
    }

    fn take(&mut self, sample: &RawSample, into: &mut Record) -> Result<Reading, ReadError> {
        let (bytes, _) = raw::open_sample(sample, &self.wire);
        let good = match &mut self.scratch {
            Some(scratch) => scratch.decode_message(bytes).is_ok() && into.swap(scratch).is_ok(),
            None => into.set_bytes(bytes).is_ok(),
        };
        if !good {
            self.dropped += 1;
            return Err(ReadError::Serialization);
        }
        self.any = true;
        Ok(Reading::New)
    }

    fn nothing(&self) -> Reading {
        if self.any { Reading::Same } else { Reading::Never }
    }
}

fn receive(from: &RawSubscriber) -> Result<Option<RawSample>, ReadError> {
    from.receive().map_err(|_| ReadError::Broken)
}

impl ShmSubscription {
    /// Takes the newest sample; skips those before it.
    fn newest(&mut self) -> Result<Option<RawSample>, ReadError> {
        let mut newest = None;
        while let Some(sample) = receive(&self.subscriber)? {
            newest = Some(sample);
        }
        Ok(newest)
    }

    /// The oldest sample of the queue. The newest one on the port's own service tells where this
    /// reader starts and what a full queue refused, since writers put a sample into the queue
    /// first.
    fn read_queue(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        if let Some(sample) = self.queued()? {
            return self.values.take(&sample, into);
        }
        // Check before reading the port: samples from before the writer joined are not in the
        // queue.
        let joined = self.queue.as_ref().is_some_and(Queue::is_joined);
        if let Some(sample) = self.newest()? {
            self.held = Some(sample);
        }
        let Some(held) = self.held.take() else { return Ok(self.values.nothing()) };
        let Some(stamp) = self.values.stamp(&held) else {
            // A foreign writer that does not fill queues: only its newest sample is available.
            return self.values.take(&held, into);
        };
        if let Some(sample) = self.queued()? {
            self.held = Some(held);
            return self.values.take(&sample, into);
        }
        match self.values.last_of(stamp.writer) {
            Some(last) => {
                let missing = stamp.number.saturating_sub(last);
                if missing > 0 {
                    self.values.dropped += missing;
                    self.values.last = Some(stamp);
                }
                Ok(self.values.nothing())
            }
            None if joined => {
                self.values.last = Some(stamp);
                self.values.take(&held, into)
            }
            None => {
                self.held = Some(held);
                Ok(self.values.nothing())
            }
        }
    }

    fn queued(&mut self) -> Result<Option<RawSample>, ReadError> {
        let Some(queue) = &self.queue else { return Ok(None) };
        while let Some(sample) = receive(&queue.subscriber)? {
            if self.values.is_next(&sample) {
                return Ok(Some(sample));
            }
        }
        Ok(None)
    }
}

impl Subscription for ShmSubscription {
    fn read(&mut self, into: &mut Record) -> Result<Reading, ReadError> {
        if let Some(start) = self.start.take() {
            self.values.last = self.values.stamp(&start);
            return self.values.take(&start, into);
        }
        if self.queue.is_some() {
            return self.read_queue(into);
        }
        if self.latest {
            return match self.newest()? {
                Some(sample) => self.values.take(&sample, into),
                None => Ok(self.values.nothing()),
            };
        }
        match receive(&self.subscriber)? {
            Some(sample) => {
                self.values.is_next(&sample);
                self.values.take(&sample, into)
            }
            None => Ok(self.values.nothing()),
        }
    }

    fn dropped(&self) -> u64 {
        self.values.dropped
    }
}
