//! What arrives on one topic, for all in ports of this daemon that read it.
//!
//! There is one DDS reader per topic, daemon and wish of quality: DDS caches samples by topic, and
//! a second reader would get old ones. An in port that comes later gets the last value from here.
//! The reader is made anew when writers come that offer something else (`quality`).

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use rustdds::{GUID, Timestamp};

use crate::complaints::Complaints;
use crate::graph::{Graph, Verdict, Wanted};
use crate::inbox::{Inbox, Message};
use crate::numbering::Place;
use crate::quality::{Asks, Wish};
use crate::receiver::{Sample, Sink};

/// A new reader is to start with the last value, but DDS also delivers what was written while it
/// was being connected. Of what arrives together within this time, only the newest is kept.
const ACQUAINTANCE: Duration = Duration::from_millis(100);

/// Writers that are remembered, though they may be gone.
const MANY: usize = 64;

/// Messages that nobody holds any more and that are kept, for their memory.
const SPARES: usize = 4;

/// The samples of a topic.
pub(crate) struct Feed {
    pub(crate) topic: String,
    pub(crate) dds_type: String,
    /// By which ROS nodes know the type.
    pub(crate) hash: Option<String>,
    digest: String,
    pub(crate) graph: Arc<Graph>,
    /// This daemon's participant: samples of its own ports come by [`Feed::hear`].
    ourselves: GUID,
    /// What was received before is of an earlier reader of the topic.
    since: Timestamp,
    /// Samples of another type.
    refused: Complaints,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    inboxes: Vec<Weak<Inbox>>,
    /// Writer and message that came last.
    last: Option<(GUID, Message)>,
    /// See [`SPARES`].
    spares: Vec<Message>,
    writers: HashMap<GUID, Known>,
    /// Undecodable samples that were told.
    told: u64,
}

/// What is known of a writer.
struct Known {
    /// Its last message.
    last: Place,
    /// The last one that was delivered.
    delivered: Option<Place>,
    verdict: Verdict,
    /// Whether it is a genomd's.
    genomd: bool,
    /// Version of the graph that these two are of.
    version: u64,
    /// Its newest sample of those that arrived together, while it is new or not known yet.
    held: Option<(Place, Message)>,
    /// When it was first heard of.
    since: Instant,
}

impl Known {
    /// Delivers what stands at this place: how many samples after the last one were not.
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

    /// What a reader asks for, with the writers there are.
    pub(crate) fn asks(&self, wish: Wish) -> Asks {
        wish.asks(&self.ourselves, &self.graph.others(&self.topic, true))
    }

    /// A sample of this daemon's own out port.
    pub(crate) fn hear(&self, writer: GUID, message: &[u8]) {
        let mut state = self.lock();
        let message = state.copy(message);
        state.deliver(writer, message);
    }

    /// The last value of this daemon's own out port, unless it came already.
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

    /// Adds an in port; it gets the last value if its writer is still there.
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

    /// Counts a sample of another type, and tells it now and then.
    fn refuse(&self, state: &State) {
        state.live().for_each(|inbox| _ = inbox.refused.fetch_add(1, Ordering::Relaxed));
        if let Some(samples) = self.refused.add() {
            tracing::warn!(topic = %self.topic, samples, "refused: a writer of another type");
        }
    }

    /// Learns what the graph knows of a writer.
    fn judge(&self, writer: &GUID, known: &mut Known, version: u64) {
        known.verdict = self.graph.writes(writer, &self.digest, &self.dds_type);
        known.genomd = self.graph.is_told(writer);
        known.version = version;
    }

    /// Tells of samples that readers could not decode, if there are more of them.
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

    /// Counts samples that did not come, or gave way to newer ones that came with them.
    fn miss(&self, samples: u64) {
        if samples > 0 {
            self.live().for_each(|inbox| _ = inbox.missing.fetch_add(samples, Ordering::Relaxed));
        }
    }

    /// A message of these bytes.
    fn copy(&mut self, bytes: &[u8]) -> Message {
        let mut message = self.spares.pop().unwrap_or_default();
        let buffer = Arc::make_mut(&mut message);
        buffer.clear();
        buffer.extend_from_slice(bytes);
        message
    }

    /// A message of these bytes, which are exchanged for a buffer to be used again.
    fn own(&mut self, bytes: &mut Vec<u8>) -> Message {
        let mut message = self.spares.pop().unwrap_or_default();
        std::mem::swap(Arc::make_mut(&mut message), bytes);
        message
    }

    fn live(&self) -> impl Iterator<Item = Arc<Inbox>> {
        self.inboxes.iter().filter_map(Weak::upgrade)
    }
}

/// Keeps a message for its memory, if nobody else holds it.
fn keep(spares: &mut Vec<Message>, mut old: Message) {
    if spares.len() < SPARES && Arc::get_mut(&mut old).is_some() {
        spares.push(old);
    }
}

impl Feed {
    /// Hands over what was held of writers that are known by now.
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

/// The receiving thread's end.
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
        // What was held is older than this, and arrived together with it.
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
        // An empty message cannot be decoded: readers count it and report it.
        self.0.lock().live().for_each(|inbox| _ = inbox.put(&Message::default()));
    }
}
