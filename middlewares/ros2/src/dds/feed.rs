//! The samples of one topic, distributed to all in ports of this daemon that read it.
//!
//! There is one DDS reader per daemon, topic and requested QoS: DDS caches samples by topic, and a
//! second reader would get old ones. An in port that is opened later gets the last value from here.
//! The reader is recreated when writers with another QoS appear (`quality`).

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use crate::dds::rustdds::{GUID, Timestamp};
use genom_kit::complaints::Complaints;

use crate::dds::graph::{Graph, Verdict, Wanted};
use crate::dds::numbering::Place;
use crate::dds::quality::{Asks, Wish};
use crate::dds::receiver::{Sample, Sink};
use crate::inbox::{Inbox, Message};

/// A new reader should start with the last value, but DDS also delivers what was written while it
/// was being connected. Of the samples that arrive within this time only the newest is kept.
const ACQUAINTANCE: Duration = Duration::from_millis(100);

/// Number of writers that are remembered although they may be gone.
const MANY: usize = 64;

/// Number of unused messages that are kept for their memory.
const SPARES: usize = 4;

/// The samples of a topic.
pub(crate) struct Feed {
    pub(crate) topic: String,
    pub(crate) dds_type: String,
    /// Type hash by which ROS nodes identify the type.
    pub(crate) hash: Option<String>,
    digest: String,
    pub(crate) graph: Arc<Graph>,
    /// This daemon's participant: samples of its own ports arrive through [`Feed::hear`].
    ourselves: GUID,
    /// Samples received before this time belong to an earlier reader of the topic.
    since: Timestamp,
    /// Counts samples of another type.
    refused: Complaints,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    inboxes: Vec<Weak<Inbox>>,
    /// Writer and content of the last message.
    last: Option<(GUID, Message)>,
    /// See [`SPARES`].
    spares: Vec<Message>,
    writers: HashMap<GUID, Known>,
    /// Number of undecodable samples when the last line was logged.
    told: u64,
}

/// State of one writer.
struct Known {
    /// Place of its last message.
    last: Place,
    /// Place of the last message that was delivered.
    delivered: Option<Place>,
    verdict: Verdict,
    /// Whether the writer is a genomd.
    genomd: bool,
    /// Version of the graph for which `verdict` and `genomd` were determined.
    version: u64,
    /// Newest of the samples that arrived together, while the writer is new or not known yet.
    held: Option<(Place, Message)>,
    /// When it was first heard of.
    since: Instant,
}

impl Known {
    /// Records that the message at this place is delivered. Returns how many samples were lost
    /// before it.
    fn reach(&mut self, place: Place) -> u64 {
        let last = self.delivered.replace(place);
        last.map_or(0, |last| last.missing(&place, self.genomd))
    }
}

impl Feed {
    pub(crate) fn new(wanted: &Wanted, graph: Arc<Graph>, ourselves: GUID) -> Self {
        Self {
            topic: wanted.topic.clone(),
            dds_type: wanted.dds_type.clone(),
            hash: wanted.hash.clone(),
            digest: wanted.digest.clone(),
            graph,
            ourselves,
            since: Timestamp::now(),
            refused: Complaints::default(),
            state: Mutex::default(),
        }
    }

    /// The QoS that a reader requests, given the writers that exist.
    pub(crate) fn asks(&self, wish: Wish) -> Asks {
        wish.asks(&self.ourselves, &self.graph.others(&self.topic, true))
    }

    /// Receives a sample of this daemon's own out port.
    pub(crate) fn hear(&self, writer: GUID, message: &[u8]) {
        let mut state = self.lock();
        let message = state.copy(message);
        state.deliver(writer, message);
    }

    /// Receives the last value of this daemon's own out port, unless a sample arrived before.
    pub(crate) fn hear_first(&self, writer: GUID, message: &[u8]) {
        let mut state = self.lock();
        if state.last.is_none() {
            let message = state.copy(message);
            state.deliver(writer, message);
        }
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an in port. It gets the last value if the writer still exists.
    pub(crate) fn add(&self, inbox: &Arc<Inbox>) {
        let mut state = self.lock();
        if let Some((writer, message)) = &state.last
            && self.graph.writes(writer, &self.digest, &self.dds_type) == Verdict::Right
        {
            inbox.put(message);
        }
        state.inboxes.retain(|other| other.strong_count() > 0);
        state.inboxes.push(Arc::downgrade(inbox));
    }

    /// Counts a sample of another type, and logs it at most once a second.
    fn refuse(&self, state: &State) {
        state.live().for_each(|inbox| _ = inbox.refused.fetch_add(1, Ordering::Relaxed));
        if let Some(samples) = self.refused.add() {
            tracing::warn!(topic = %self.topic, samples, "refused: a writer of another type");
        }
    }

    /// Updates what the graph knows of a writer.
    fn judge(&self, writer: &GUID, known: &mut Known, version: u64) {
        known.verdict = self.graph.writes(writer, &self.digest, &self.dds_type);
        known.genomd = self.graph.is_told(writer);
        known.version = version;
    }

    /// Logs the number of samples that readers could not decode, if it has grown.
    pub(crate) fn complain(&self) {
        let mut state = self.lock();
        let samples = state.live().map(|inbox| inbox.undecodable.load(Ordering::Relaxed)).sum();
        if samples > state.told {
            tracing::warn!(topic = %self.topic, samples, "samples cannot be decoded");
        }
        state.told = samples;
    }
}

impl State {
    fn deliver(&mut self, writer: GUID, message: Message) {
        let Self { inboxes, spares, .. } = self;
        inboxes.retain(|inbox| {
            let inbox = inbox.upgrade();
            inbox.is_some_and(|inbox| {
                inbox.put(&message).into_iter().for_each(|old| keep(spares, old));
                true
            })
        });
        if let Some((_, old)) = self.last.replace((writer, message)) {
            keep(&mut self.spares, old);
        }
    }

    /// Counts samples that did not arrive, or were replaced by newer ones that arrived with them.
    fn miss(&self, samples: u64) {
        if samples > 0 {
            self.live().for_each(|inbox| _ = inbox.missing.fetch_add(samples, Ordering::Relaxed));
        }
    }

    /// A message with a copy of these bytes.
    fn copy(&mut self, bytes: &[u8]) -> Message {
        let mut message = self.spares.pop().unwrap_or_default();
        let buffer = Arc::make_mut(&mut message);
        buffer.clear();
        buffer.extend_from_slice(bytes);
        message
    }

    /// A message that takes over these bytes; leaves a buffer for reuse in their place.
    fn own(&mut self, bytes: &mut Vec<u8>) -> Message {
        let mut message = self.spares.pop().unwrap_or_default();
        std::mem::swap(Arc::make_mut(&mut message), bytes);
        message
    }

    fn live(&self) -> impl Iterator<Item = Arc<Inbox>> {
        self.inboxes.iter().filter_map(Weak::upgrade)
    }
}

/// Keeps a message for its memory if nobody else holds it.
fn keep(spares: &mut Vec<Message>, mut old: Message) {
    if spares.len() < SPARES && Arc::get_mut(&mut old).is_some() {
        spares.push(old);
    }
}

impl Feed {
    /// Delivers the held samples of writers that are known by now.
    pub(crate) fn settle(&self) {
        let mut state = self.lock();
        if state.writers.values().all(|known| known.held.is_none()) {
            return;
        }
        let version = self.graph.version();
        let mut settled = Vec::new();
        for (writer, known) in &mut state.writers {
            let Some((place, message)) = known.held.take() else { continue };
            self.judge(writer, known, version);
            match known.verdict {
                Verdict::Unknown => known.held = Some((place, message)),
                Verdict::Right => settled.push((*writer, known.reach(place), Some(message))),
                Verdict::Wrong => settled.push((*writer, 0, None)),
            }
        }
        for (writer, missing, message) in settled {
            if let Some(message) = message {
                state.miss(missing);
                state.deliver(writer, message);
            } else {
                self.refuse(&state);
            }
        }
    }
}

/// The receiving thread's handle of a feed.
pub(crate) struct FeedSink(pub(crate) Arc<Feed>);

impl Sink for FeedSink {
    fn arrive(&mut self, sample: Sample<'_>) {
        let feed = &*self.0;
        if sample.received < feed.since || sample.writer.prefix == feed.ourselves.prefix {
            return;
        }
        let version = feed.graph.version();
        let mut state = feed.lock();
        if state.writers.len() > MANY && !state.writers.contains_key(&sample.writer) {
            let here = |writer: &GUID| feed.graph.writes(writer, &feed.digest, &feed.dds_type);
            state.writers.retain(|writer, _| here(writer) != Verdict::Unknown);
        }
        let known = state.writers.entry(sample.writer).or_insert(Known {
            last: Place::default(),
            delivered: None,
            verdict: Verdict::Unknown,
            genomd: false,
            version,
            held: None,
            since: Instant::now(),
        });
        let place = Place::new(sample.number, sample.stamp);
        if !place.is_after(&known.last) {
            return;
        }
        known.last = place;
        if known.verdict == Verdict::Unknown || known.since.elapsed() < ACQUAINTANCE {
            let message = state.own(sample.message);
            let known = state.writers.get_mut(&sample.writer);
            let old = known.and_then(|known| known.held.replace((place, message)));
            old.into_iter().for_each(|(_, old)| keep(&mut state.spares, old));
            return;
        }
        // The held sample is older than this one, and arrived together with it.
        known.held = None;
        if known.version != version {
            feed.judge(&sample.writer, known, version);
        }
        if known.verdict == Verdict::Wrong {
            feed.refuse(&state);
        } else {
            let missing = known.reach(place);
            state.miss(missing);
            let message = state.own(sample.message);
            state.deliver(sample.writer, message);
        }
    }

    fn pause(&mut self) {
        self.0.settle();
    }

    fn garbled(&mut self) {
        // An empty message cannot be decoded, so the readers count and report it.
        self.0.lock().live().for_each(|inbox| _ = inbox.put(&Message::default()));
    }
}
