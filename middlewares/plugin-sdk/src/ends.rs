//! The two ends of a port: samples as messages, whichever way the backend takes and gives them.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use genom_middleware::{PublishError, Publisher, ReadError, Reading, Subscription};
use genom_plugin_abi::Code;
use genom_types::{DataType, Record};

use crate::given::Given;

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A publisher.
pub(crate) struct Writer {
    inner: Mutex<Publishing>,
    lost: AtomicU64,
}

struct Publishing {
    publisher: Box<dyn Publisher>,
    /// For backends that take records only.
    record: Record,
    scratch: Record,
}

impl Writer {
    pub(crate) fn new(publisher: Box<dyn Publisher>, ty: &DataType) -> Self {
        let (record, scratch) = (Record::new(ty), Record::new(ty));
        Self {
            inner: Mutex::new(Publishing { publisher, record, scratch }),
            lost: AtomicU64::new(0),
        }
    }

    pub(crate) fn write(&self, message: &[u8]) -> Code {
        let mut inner = lock(&self.inner);
        let Publishing { publisher, record, scratch } = &mut *inner;
        let published = match publisher.publish_message(message) {
            Some(published) => published,
            None => match record.replace_from_message(message, scratch) {
                Ok(()) => publisher.publish(record),
                Err(_) => Err(PublishError::Serialization),
            },
        };
        match published {
            Ok(()) => Code::OK,
            Err(PublishError::Serialization) => Code::BAD_DATA,
            Err(_) => Code::FAILED,
        }
    }

    /// While a sample is being published, what was lost before.
    pub(crate) fn lost(&self) -> u64 {
        if let Ok(inner) = self.inner.try_lock() {
            self.lost.store(inner.publisher.dropped(), Ordering::Relaxed);
        }
        self.lost.load(Ordering::Relaxed)
    }
}

/// A subscription that passes on what arrives.
pub(crate) struct Feed {
    inner: Mutex<Option<Reader>>,
    /// Arrivals that were told and not looked after yet. Only who raises it from 0 reads.
    told: AtomicUsize,
    lost: AtomicU64,
}

struct Reader {
    subscription: Box<dyn Subscription>,
    to: Arc<Given>,
    record: Record,
    message: Vec<u8>,
}

impl Feed {
    /// `None` if the backend does not tell of samples that arrive.
    pub(crate) fn start(
        mut subscription: Box<dyn Subscription>,
        to: Arc<Given>,
        ty: &DataType,
    ) -> Option<Arc<Self>> {
        let feed = Arc::new(Self {
            inner: Mutex::new(None),
            told: AtomicUsize::new(0),
            lost: AtomicU64::new(0),
        });
        let told = Arc::downgrade(&feed);
        let tells = subscription.on_arrival(Box::new(move || {
            if let Some(feed) = told.upgrade() {
                feed.pass_on();
            }
        }));
        if !tells {
            return None;
        }
        let (record, message) = (Record::new(ty), Vec::new());
        *lock(&feed.inner) = Some(Reader { subscription, to, record, message });
        // What arrived before is not told.
        feed.pass_on();
        Some(feed)
    }

    /// Passes on all that arrived. Never waits for another thread that does, and may be called from
    /// within itself: whoever reads looks again.
    fn pass_on(&self) {
        if self.told.fetch_add(1, Ordering::AcqRel) > 0 {
            return;
        }
        loop {
            let seen = self.told.load(Ordering::Acquire);
            if let Some(reader) = &mut *lock(&self.inner) {
                while reader.next() {}
                self.lost.store(reader.subscription.dropped(), Ordering::Relaxed);
            }
            if self.told.fetch_sub(seen, Ordering::AcqRel) == seen {
                return;
            }
        }
    }

    pub(crate) fn lost(&self) -> u64 {
        if let Ok(inner) = self.inner.try_lock()
            && let Some(reader) = &*inner
        {
            self.lost.store(reader.subscription.dropped(), Ordering::Relaxed);
        }
        self.lost.load(Ordering::Relaxed)
    }

    pub(crate) fn close(&self) {
        let closed = lock(&self.inner).take();
        drop(closed);
    }
}

impl Reader {
    /// Passes on the next sample. Returns whether there may be more.
    fn next(&mut self) -> bool {
        let read = match self.subscription.read_message(&mut self.message) {
            Some(read) => read,
            None => self.encoded(),
        };
        match read {
            Ok(Reading::New) => {
                self.to.sample(&self.message);
                true
            }
            Ok(Reading::Same | Reading::Never) => false,
            // This one is counted as lost; the next one may be readable.
            Err(ReadError::Serialization) => true,
            Err(_) => false,
        }
    }

    fn encoded(&mut self) -> Result<Reading, ReadError> {
        let read = self.subscription.read(&mut self.record)?;
        if read == Reading::New {
            self.message.clear();
            let encoded = self.record.encode_message(&mut self.message);
            encoded.map_err(|_| ReadError::Serialization)?;
        }
        Ok(read)
    }
}
