//! The in ports of this daemon, and where their samples arrive.

use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Weak};
use std::time::Instant;

use genom_kit::complaints::BETWEEN_LINES;
use zenoh::key_expr::OwnedKeyExpr;
use zenoh::pubsub::Subscriber;
use zenoh::sample::{Sample, SampleKind};
use zenoh::{Session, Wait};
use zenoh_ext::{AdvancedSubscriber, AdvancedSubscriberBuilderExt, HistoryConfig};

use super::attachment::Attachment;
use super::graph::Graph;
use super::keys;
use super::numbers::Numbers;
use super::refusals::{Reason, Refusals};
use crate::inbox::{Inbox, Message};
use crate::lock::lock;
use crate::rmw::Wanted;

/// Number of keys that an in port reads, its own among them.
const KEYS: usize = 16;

/// An in port. It reads the key of its type and, since types of equal members may have other names
/// in other daemons, the keys of those of their writers that it can read.
pub(crate) struct Reader {
    domain: u16,
    name: String,
    digest: String,
    arrivals: Arc<Arrivals>,
    own: OwnedKeyExpr,
    /// Whether it also reads what is written on [`keys::of_buffers`].
    buffers: bool,
    subscribers: Mutex<Subscribers>,
    /// Whether there may be keys of writers that it does not read yet.
    news: AtomicBool,
}

/// By key.
type Subscribers = HashMap<OwnedKeyExpr, (AdvancedSubscriber<()>, Option<Subscriber<()>>)>;

/// Filled by zenoh's callbacks.
pub(crate) struct Arrivals {
    name: String,
    inbox: Arc<Inbox>,
    gate: Mutex<Gate>,
    refusals: Arc<Refusals>,
}

#[derive(Default)]
struct Gate {
    numbers: Numbers,
    /// An unused message, kept for its memory.
    spare: Option<Message>,
    /// Number of undecodable samples when the last line was logged, and when that was.
    logged: (u64, Option<Instant>),
}

impl Arrivals {
    pub(crate) fn new(topic: &str, inbox: &Arc<Inbox>, refusals: &Arc<Refusals>) -> Self {
        let (name, inbox, refusals) = (topic.to_owned(), Arc::clone(inbox), Arc::clone(refusals));
        Self { name, inbox, gate: Mutex::default(), refusals }
    }

    fn arrive(&self, sample: &Sample) {
        if sample.kind() != SampleKind::Put {
            return;
        }
        let refuse = |why| {
            self.inbox.refused.fetch_add(1, Ordering::Relaxed);
            self.refusals.add(why, sample.key_expr().as_str());
        };
        let mut gate = lock(&self.gate);
        // Without an attachment, as plain zenoh programs send it, all samples are new.
        if let Some(attachment) = sample.attachment() {
            let Some(attachment) = Attachment::decode(attachment) else {
                return refuse(Reason::Attachment);
            };
            let Some(missing) = gate.numbers.admit(attachment) else { return };
            if missing > 0 {
                self.inbox.missing.fetch_add(missing, Ordering::Relaxed);
            }
        }
        if sample.payload().len() > self.refusals.greatest {
            return refuse(Reason::Sample);
        }
        // The gate is still locked, so there is one producer at a time.
        let (held, mut old) = self.inbox.hold(sample.payload());
        if !held {
            let mut message = gate.spare.take().unwrap_or_default();
            let buffer = Arc::make_mut(&mut message);
            buffer.clear();
            sample.payload().slices().for_each(|part| buffer.extend_from_slice(part));
            old = self.inbox.put(&message);
        }
        if let Some(old) = old.filter(|old| Arc::strong_count(old) == 1) {
            gate.spare = Some(old);
        }
        gate.report(self);
    }
}

impl Gate {
    fn report(&mut self, of: &Arrivals) {
        let samples = of.inbox.undecodable.load(Ordering::Relaxed);
        let (logged, line) = self.logged;
        if samples == logged || line.is_some_and(|line| line.elapsed() < BETWEEN_LINES) {
            return;
        }
        self.logged = (samples, Some(Instant::now()));
        tracing::warn!(topic = %of.name, samples, "samples cannot be decoded");
    }
}

impl Reader {
    /// Reads this key, with what is written for readers of buffers if that is true, and further
    /// keys as soon as they are known.
    pub(crate) fn open(
        session: &Session,
        domain: u16,
        wanted: &Wanted,
        (key, buffers): (OwnedKeyExpr, bool),
        arrivals: Arrivals,
    ) -> zenoh::Result<Arc<Self>> {
        let reader = Arc::new(Self {
            domain,
            name: wanted.of.name.clone(),
            digest: wanted.digest.clone(),
            arrivals: Arc::new(arrivals),
            own: key.clone(),
            buffers,
            subscribers: Mutex::default(),
            news: AtomicBool::new(false),
        });
        let mut subscribers = lock(&reader.subscribers);
        reader.read(session, key, &mut subscribers)?;
        drop(subscribers);
        Ok(reader)
    }

    fn read(
        &self,
        session: &Session,
        key: OwnedKeyExpr,
        subscribers: &mut Subscribers,
    ) -> zenoh::Result<()> {
        if subscribers.contains_key(&key) {
            return Ok(());
        }
        let arrivals = Arc::clone(&self.arrivals);
        let subscriber = session
            .declare_subscriber(key.clone())
            .callback(move |sample| arrivals.arrive(&sample))
            // Writers that keep their last value send it: all of daemons, and of ROS nodes those
            // that are transient local.
            .history(HistoryConfig::default().detect_late_publishers().max_samples(1))
            .subscriber_detection()
            .wait()?;
        let of_buffers = || {
            let arrivals = Arc::clone(&self.arrivals);
            let subscriber = session.declare_subscriber(keys::of_buffers(&key));
            subscriber.callback(move |sample| arrivals.arrive(&sample)).wait()
        };
        let of_buffers = self.buffers.then(of_buffers).transpose()?;
        subscribers.insert(key, (subscriber, of_buffers));
        Ok(())
    }

    /// Notes that there may be further keys; whether nobody has noted that already.
    pub(crate) fn is_to_follow(&self) -> bool {
        !self.news.swap(true, Ordering::AcqRel)
    }

    /// Reads further keys of known writers.
    pub(crate) fn follow(&self, session: &Session, graph: &Graph) {
        self.news.store(false, Ordering::Release);
        let equals = graph.equals(&self.name, &self.digest).into_iter();
        let keys = equals.filter_map(|(ty, hash)| {
            keys::of_found(self.domain, &self.name, &ty, &hash)
                .inspect_err(|error| {
                    tracing::warn!(topic = %self.name, %error, "a writer cannot be read");
                })
                .ok()
        });
        let keys: HashSet<OwnedKeyExpr> = keys.collect();
        let mut subscribers = lock(&self.subscribers);
        if keys.len() + subscribers.len() > KEYS {
            // Writers of some may be gone.
            subscribers.retain(|key, _| *key == self.own || keys.contains(key));
        }
        for key in keys {
            if subscribers.len() >= KEYS && !subscribers.contains_key(&key) {
                self.arrivals.refusals.add(Reason::Types, &key);
            } else if let Err(error) = self.read(session, key, &mut subscribers) {
                tracing::warn!(topic = %self.name, %error, "a writer cannot be read");
            }
        }
    }
}

/// The in ports of this daemon, by topic.
#[derive(Default)]
pub(crate) struct Readers(Mutex<HashMap<String, Vec<Weak<Reader>>>>);

impl Readers {
    pub(crate) fn add(&self, reader: &Arc<Reader>) {
        let mut all = lock(&self.0);
        all.retain(|_, readers| {
            readers.retain(|reader| reader.strong_count() > 0);
            !readers.is_empty()
        });
        all.entry(reader.name.clone()).or_default().push(Arc::downgrade(reader));
    }

    /// The in ports of a topic.
    pub(crate) fn of(&self, name: &str) -> Vec<Arc<Reader>> {
        lock(&self.0).get(name).into_iter().flatten().filter_map(Weak::upgrade).collect()
    }
}
