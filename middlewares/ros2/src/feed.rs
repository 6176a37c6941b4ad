//! What arrives on one topic, for all in ports of this daemon that read it.
//!
//! There is one DDS reader per topic and daemon: DDS caches samples by topic, and a second reader
//! would get old ones. An in port that comes later gets the last value from here.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use genom_middleware::Policy;
use genom_middleware::mailbox::{Full, Mailbox};
use rustdds::mio1::Token;
use rustdds::{GUID, Timestamp};

use crate::graph::{Graph, Verdict, Wanted};
use crate::receiver::{Inlet, Sample, Sink};

/// At most one line about bad samples in this time.
const BETWEEN_LINES: Duration = Duration::from_secs(1);

/// A reader starts with the last value; but DDS brings at first what was written while it
/// connected. Of what arrives together within this time, only the newest counts.
const ACQUAINTANCE: Duration = Duration::from_millis(100);

/// Writers that are remembered, though they may be gone.
const MANY: usize = 64;

/// Samples of one in port that wait to be read.
#[derive(Debug)]
pub(crate) struct Inbox {
    pub(crate) mailbox: Mailbox,
    /// Whether samples that gave way are losses: not for `latest`.
    counts_lost: bool,
    /// Samples that could not be decoded.
    pub(crate) undecodable: AtomicU64,
}

impl Inbox {
    pub(crate) fn new(policy: Policy, size: usize) -> Self {
        let (depth, full, counts_lost) = match policy {
            Policy::Latest => (1, Full::Oldest, false),
            Policy::Queue(depth) => (depth, Full::Newest, true),
            Policy::Ring(depth) => (depth, Full::Oldest, true),
        };
        Self {
            mailbox: Mailbox::new(depth, size, full),
            counts_lost,
            undecodable: AtomicU64::new(0),
        }
    }

    /// Samples lost to the reader.
    pub(crate) fn lost(&self) -> u64 {
        let given_up = if self.counts_lost { self.mailbox.lost() } else { 0 };
        given_up + self.undecodable.load(Ordering::Relaxed)
    }

    fn put(&self, message: &[u8]) {
        let put = self.mailbox.put(|buffer| {
            buffer.extend_from_slice(message);
            Ok::<_, std::convert::Infallible>(())
        });
        if put.is_err() {
            self.undecodable.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// The samples of a topic.
pub(crate) struct Feed {
    pub(crate) topic: String,
    dds_type: String,
    digest: String,
    graph: Arc<Graph>,
    /// This daemon: its own samples come another way.
    ourselves: GUID,
    /// What was received before is of an earlier reader of the topic.
    since: Timestamp,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    inboxes: Vec<Weak<Inbox>>,
    /// Writer and message that came last.
    last: Option<(GUID, Vec<u8>)>,
    writers: HashMap<GUID, Known>,
    bad: u64,
    line: Option<Instant>,
}

/// What is known of a writer.
struct Known {
    /// Time of its last sample, as it says.
    stamp: Option<Timestamp>,
    verdict: Verdict,
    /// Version of the graph the verdict is of.
    version: u64,
    /// Its newest sample of those that arrived together, while it is new or not known yet.
    held: Option<Vec<u8>>,
    /// When it was first heard of.
    since: Instant,
}

/// Keeps a topic read. The last one to go ends the DDS reader.
pub(crate) struct FeedHandle {
    pub(crate) feed: Arc<Feed>,
    pub(crate) token: Token,
    pub(crate) guid: GUID,
    pub(crate) inlet: Arc<Inlet>,
}

impl Drop for FeedHandle {
    fn drop(&mut self) {
        self.inlet.remove(self.token);
    }
}

impl Feed {
    pub(crate) fn new(wanted: &Wanted, graph: Arc<Graph>, ourselves: GUID) -> Self {
        Self {
            topic: wanted.topic.clone(),
            dds_type: wanted.dds_type.clone(),
            digest: wanted.digest.clone(),
            graph,
            ourselves,
            since: Timestamp::now(),
            state: Mutex::default(),
        }
    }

    /// A sample of this daemon's own out port.
    pub(crate) fn hear(&self, writer: GUID, message: &[u8]) {
        self.lock().deliver(writer, message);
    }

    /// The last value of this daemon's own out port, unless it came already.
    pub(crate) fn hear_first(&self, writer: GUID, message: &[u8]) {
        let mut state = self.lock();
        if state.last.is_none() {
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

    fn report(&self, state: &mut State, why: &str) {
        state.bad += 1;
        if state.line.is_none_or(|line| line.elapsed() > BETWEEN_LINES) {
            state.line = Some(Instant::now());
            tracing::warn!(topic = %self.topic, samples = state.bad, "refused: {why}");
        }
    }
}

impl State {
    fn deliver(&mut self, writer: GUID, message: &[u8]) {
        self.inboxes.retain(|inbox| {
            let inbox = inbox.upgrade();
            inbox.is_some_and(|inbox| {
                inbox.put(message);
                true
            })
        });
        let (by, last) = self.last.get_or_insert_with(|| (writer, Vec::new()));
        *by = writer;
        last.clear();
        last.extend_from_slice(message);
    }

    fn count_refused(&self) {
        let inboxes = self.inboxes.iter().filter_map(Weak::upgrade);
        inboxes.for_each(|inbox| _ = inbox.undecodable.fetch_add(1, Ordering::Relaxed));
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
            let Some(held) = known.held.take() else { continue };
            known.verdict = self.graph.writes(writer, &self.digest, &self.dds_type);
            known.version = version;
            match known.verdict {
                Verdict::Unknown => known.held = Some(held),
                verdict => settled.push((*writer, verdict, held)),
            }
        }
        for (writer, verdict, held) in settled {
            if verdict == Verdict::Right {
                state.deliver(writer, &held);
            } else {
                state.count_refused();
                self.report(&mut state, OTHER_TYPE);
            }
        }
    }
}

const OTHER_TYPE: &str = "a writer of another type";

/// The receiving thread's end.
pub(crate) struct FeedSink(pub(crate) Arc<Feed>);

impl Sink for FeedSink {
    fn arrive(&mut self, sample: &Sample<'_>) {
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
            stamp: None,
            verdict: Verdict::Unknown,
            version,
            held: None,
            since: Instant::now(),
        });
        // A new reader is sent the last value besides: it may come twice.
        if sample.stamp.is_some() && known.stamp == sample.stamp {
            return;
        }
        known.stamp = sample.stamp;
        if known.verdict == Verdict::Unknown || known.since.elapsed() < ACQUAINTANCE {
            let held = known.held.get_or_insert_default();
            held.clear();
            held.extend_from_slice(sample.message);
            return;
        }
        // What was held is older than this, and arrived together with it.
        known.held = None;
        if known.version != version {
            known.verdict = feed.graph.writes(&sample.writer, &feed.digest, &feed.dds_type);
            known.version = version;
        }
        if known.verdict == Verdict::Wrong {
            state.count_refused();
            feed.report(&mut state, OTHER_TYPE);
        } else {
            state.deliver(sample.writer, sample.message);
        }
    }

    fn pause(&mut self) {
        self.0.settle();
    }

    fn garbled(&mut self) {
        let mut state = self.0.lock();
        state.count_refused();
        self.0.report(&mut state, "not plain CDR");
    }
}

/// The topics this daemon reads.
#[derive(Default)]
pub(crate) struct Feeds(Mutex<HashMap<String, Weak<FeedHandle>>>);

impl Feeds {
    fn lock(&self) -> MutexGuard<'_, HashMap<String, Weak<FeedHandle>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The feed of a topic, made unless there is one.
    pub(crate) fn get(
        &self,
        topic: &str,
        make: impl FnOnce() -> Result<FeedHandle, String>,
    ) -> Result<Arc<FeedHandle>, String> {
        let mut feeds = self.lock();
        if let Some(feed) = feeds.get(topic).and_then(Weak::upgrade) {
            return Ok(feed);
        }
        feeds.retain(|_, feed| feed.strong_count() > 0);
        let handle = Arc::new(make()?);
        feeds.insert(topic.to_owned(), Arc::downgrade(&handle));
        Ok(handle)
    }

    /// The feed of a topic, if it is read.
    pub(crate) fn find(&self, topic: &str) -> Option<Arc<Feed>> {
        // Out of the lock before it goes: the last one to let go of a feed may be this.
        let handle = self.lock().get(topic).and_then(Weak::upgrade);
        handle.map(|handle| Arc::clone(&handle.feed))
    }

    /// There is news of writers.
    pub(crate) fn settle(&self) {
        let feeds: Vec<_> = self.lock().values().filter_map(Weak::upgrade).collect();
        feeds.iter().for_each(|handle| handle.feed.settle());
    }
}
