//! Work of the sending thread: samples of out ports, announcements of this daemon, replies.

use std::collections::HashMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use crate::dds::rustdds::bytes::Bytes;
use crate::dds::rustdds::{GUID, RTPSEntity, Timestamp};
use genom_kit::complaints::BETWEEN_LINES;
use genom_kit::lines::Lines;
use genom_kit::out_port::OutPort;
use genom_kit::outlet::Outlet;
use genom_kit::sender::{self, Duty};
use genom_middleware::Publisher;
use genom_rtps_guard::Flight;

use crate::dds::feed::Feed;
use crate::dds::feeds::Feeds;
use crate::dds::meetings::{self, Meetings};
use crate::dds::numbering::Numbering;
use crate::dds::patience::Patience;
use crate::dds::post::{Matches, Post};
use crate::dds::wire::{HEADER, Payload, Writer};

/// How long a large sample waits for those before it. Meanwhile newer ones take its place in the
/// outlet, as its depth says, and another thread sends for the other ports.
const IN_FLIGHT: Duration = Duration::from_millis(500);

/// Minimum time between two announcements, so that many changes at once make one.
const BETWEEN: Duration = Duration::from_millis(20);

/// Announces our ends to others.
pub(crate) trait Announce: Send {
    /// Announces. Returns false if it must be repeated.
    fn tell(&self) -> bool;

    /// Waits for a limited time until others have received the announcement. Returns whether they have.
    fn settle(&self, longest: Duration) -> bool;

    /// Logs samples that could not be decoded.
    fn complain(&self);
}

/// An out port as the sending thread sees it.
pub(crate) struct Line {
    writer: Writer,
    numbering: Numbering,
    topic: String,
    /// In ports of this daemon, which get samples directly: DDS connects a participant to itself
    /// only over multicast.
    feeds: Arc<Feeds>,
    outlet: Arc<Outlet>,
    flight: Flight,
    /// The last value, for late readers.
    last: Option<Bytes>,
}

/// Owns the thread.
pub(crate) struct Sending {
    _sender: sender::Sender<Work>,
    orders: Orders,
}

/// Gives jobs to the thread. Clones refer to the same thread.
#[derive(Clone)]
pub(crate) struct Orders {
    thread: sender::Orders<Work>,
    /// Whether there is something to announce.
    news: Arc<AtomicBool>,
    /// How often somebody asked to wait for an announcement.
    asked: Arc<AtomicU64>,
    /// Whether in ports could not decode samples.
    complaints: Arc<AtomicBool>,
}

impl Sending {
    pub(crate) fn start(announce: Box<dyn Announce>, matches: Arc<Matches>) -> io::Result<Self> {
        let news = Arc::new(AtomicBool::new(false));
        let asked = Arc::new(AtomicU64::new(0));
        let complaints = Arc::new(AtomicBool::new(false));
        let work = Work {
            lines: HashMap::new(),
            meetings: Meetings::default(),
            matches,
            announce,
            news: Arc::clone(&news),
            announced: None,
            asked: Arc::clone(&asked),
            answered: 0,
            complaints: Arc::clone(&complaints),
            complained: None,
            patience: Patience::new(),
        };
        // Not prompt, because the first thing it does is to wake DDS's threads.
        let sender = sender::Sender::start("ros2", false, work)?;
        let thread = sender.orders().clone();
        Ok(Self { _sender: sender, orders: Orders { thread, news, asked, complaints } })
    }

    pub(crate) fn orders(&self) -> &Orders {
        &self.orders
    }
}

impl Orders {
    /// Schedules an announcement of our ends.
    pub(crate) fn announce(&self) {
        self.news.store(true, Ordering::Release);
        self.thread.ring();
    }

    /// Schedules a log line about samples that could not be decoded. Wait-free.
    pub(crate) fn complain(&self) {
        self.complaints.store(true, Ordering::Release);
        self.thread.ring();
    }

    /// Announces our ends, and waits for a limited time until others have received it.
    pub(crate) fn announce_now(&self) {
        let number = self.asked.fetch_add(1, Ordering::SeqCst) + 1;
        self.thread.finish(move |work, _| work.answer(number));
    }

    /// Queues a job, after all earlier ones.
    pub(crate) fn submit(&self, job: impl FnOnce() + Send + 'static) {
        self.thread.submit(|_, _| job());
    }

    /// Waits on the thread, for a limited time, until what was sent has arrived.
    pub(crate) fn settle(&self, post: &Arc<Post>) {
        let post = Arc::clone(post);
        self.thread.finish(move |work, _| work.patience.wait(|longest| post.settle(longest)));
    }

    /// Adds an out port and returns its number.
    pub(crate) fn add(&self, line: Line) -> usize {
        let writer = line.writer.guid();
        let number = self.thread.add(line);
        self.thread.submit(move |work, _| _ = work.lines.insert(writer, number));
        number
    }

    /// Gives a newly read topic the last value of this daemon's own out port.
    pub(crate) fn offer(&self, feed: Arc<Feed>) {
        self.thread.submit(move |_, lines| {
            let last = lines.find(|line| {
                let of_topic = line.topic == feed.topic;
                of_topic.then(|| Some((line.writer.guid(), line.last.clone()?)))
            });
            if let Some((writer, payload)) = last.flatten() {
                let message = [&genom_types::cdr::HEADER[..], &payload].concat();
                feed.hear_first(writer, &message);
            }
        });
    }

    /// Sends what an out port still has queued, and removes it.
    pub(crate) fn remove(&self, line: usize) {
        self.thread.remove(line, |work, line| {
            work.lines.remove(&line.writer.guid());
            work.patience.wait(|longest| meetings::acknowledged_in(&line.writer, longest));
        });
    }

    /// DDS has connected a writer of ours and a reader.
    pub(crate) fn meet(&self, writer: GUID, reader: GUID) {
        self.thread.submit(move |work, lines| {
            if work.meetings.begin(writer, reader) {
                work.met(lines, writer, reader);
            }
        });
    }

    /// DDS has lost readers.
    pub(crate) fn part(&self, gone: impl Fn(&GUID) -> bool + Send + 'static) {
        self.thread.submit(move |work, _| {
            work.meetings.lost(&gone);
            work.matches.lost(&gone);
        });
    }

    /// The out port of the line with this number, which `end` removes.
    pub(crate) fn out_port(
        &self,
        outlet: Arc<Outlet>,
        line: usize,
        end: impl FnOnce(usize) + Send + 'static,
    ) -> Box<dyn Publisher> {
        Box::new(OutPort::new(outlet, &self.thread, line, end))
    }

    /// Blocks the first out port from sending until the result is dropped.
    pub(crate) fn stall(&self) -> impl Send + use<> {
        self.thread.stall()
    }
}

impl Line {
    pub(crate) fn new(
        writer: Writer,
        topic: String,
        outlet: &Arc<Outlet>,
        feeds: Arc<Feeds>,
    ) -> Self {
        let (numbering, outlet) = (Numbering::default(), Arc::clone(outlet));
        let flight = Flight::default();
        Self { writer, numbering, topic, feeds, outlet, flight, last: None }
    }

    fn greet(&mut self, reader: GUID) {
        let Some(payload) = &self.last else { return };
        let before = self.numbering;
        let options = self.numbering.again(reader);
        if self.writer.write_with_options(Payload(payload.clone()), options).is_err() {
            // Nothing was sent, so no sequence number was used.
            self.numbering = before;
            tracing::debug!("DDS refused the last value of a port");
        }
    }
}

impl sender::Line for Line {
    fn send(&mut self) -> bool {
        let writer = self.writer.guid();
        let Some(message) = self.outlet.take() else { return false };
        let own = self.feeds.of(&self.topic);
        for handle in &own {
            handle.feed.hear(writer, message.as_ref());
        }
        let message = Bytes::from_owner(message);
        let payload = message.slice(HEADER.min(message.len())..);
        self.last = Some(payload.clone());
        let Self { writer, flight, .. } = &mut *self;
        // Whatever has become of them then: readers may be gone, or the network slow.
        flight.add(payload.len(), || _ = writer.wait_for_acknowledgments(IN_FLIGHT));
        let options = self.numbering.next(Timestamp::now());
        if let Err(error) = self.writer.write_with_options(Payload(payload), options) {
            // What only this daemon reads was not lost: its in ports have it already.
            let others = |feed: &Feed| !feed.graph.others(&self.topic, false).is_empty();
            if own.first().is_none_or(|handle| others(&handle.feed)) {
                self.outlet.refuse();
            }
            tracing::debug!(%error, "DDS refused a sample");
        }
        true
    }
}

/// Data that jobs of the sending thread use.
struct Work {
    /// Numbers of out ports, by writer.
    lines: HashMap<GUID, usize>,
    meetings: Meetings,
    matches: Arc<Matches>,
    announce: Box<dyn Announce>,
    news: Arc<AtomicBool>,
    announced: Option<Instant>,
    asked: Arc<AtomicU64>,
    /// How many of those who asked the last announcement was for.
    answered: u64,
    complaints: Arc<AtomicBool>,
    complained: Option<Instant>,
    patience: Patience,
}

impl Duty for Work {
    type Line = Line;

    fn due(&mut self, lines: &Lines<Line>) -> Option<Duration> {
        self.look_at_meetings(lines);
        let pauses = [self.until_announcement(), self.until_complaint(), self.meetings.pause()];
        pauses.into_iter().flatten().min()
    }
}

impl Work {
    /// Announces what is due. Returns the time until the next announcement.
    fn until_announcement(&mut self) -> Option<Duration> {
        if !self.news.load(Ordering::Acquire) {
            return None;
        }
        let since = self.announced.map_or(BETWEEN, |announced| announced.elapsed());
        if since < BETWEEN {
            return Some(BETWEEN.saturating_sub(since));
        }
        self.announced = Some(Instant::now());
        self.news.store(false, Ordering::SeqCst);
        if self.announce.tell() {
            return None;
        }
        self.news.store(true, Ordering::Release);
        Some(BETWEEN)
    }

    /// Announces for who was the so-many-th to ask, and for all who have asked since: an announcement
    /// tells of all ends, so that many that close at once need no more than a few.
    fn answer(&mut self, number: u64) {
        if self.answered >= number {
            return;
        }
        let asked = self.asked.load(Ordering::SeqCst);
        if self.announce.tell() {
            let Self { announce, patience, .. } = self;
            patience.wait(|longest| announce.settle(longest));
        }
        self.answered = asked;
    }

    /// Logs undecodable samples if a line is due. Returns the time until the next line.
    fn until_complaint(&mut self) -> Option<Duration> {
        if !self.complaints.load(Ordering::Acquire) {
            return None;
        }
        let since = self.complained.map_or(BETWEEN_LINES, |complained| complained.elapsed());
        if since < BETWEEN_LINES {
            return Some(BETWEEN_LINES.saturating_sub(since));
        }
        self.complained = Some(Instant::now());
        self.complaints.store(false, Ordering::SeqCst);
        self.announce.complain();
        None
    }

    /// A reader is ready: sends it what waits for it, or the last value of the port.
    fn met(&self, lines: &Lines<Line>, writer: GUID, reader: GUID) {
        match self.matches.matched(writer, reader) {
            Some(post) => post.go_on(),
            None => _ = self.with(lines, &writer, |line| line.greet(reader)),
        }
    }

    fn with<R>(
        &self,
        lines: &Lines<Line>,
        writer: &GUID,
        work: impl FnOnce(&mut Line) -> R,
    ) -> Option<R> {
        lines.with(*self.lines.get(writer)?, work)
    }

    fn look_at_meetings(&mut self, lines: &Lines<Line>) {
        let mut meetings = std::mem::take(&mut self.meetings);
        let ready = meetings.ready(|writer| {
            let line = self.with(lines, writer, |line| meetings::acknowledged(&line.writer));
            // A writer that is not an out port's belongs to requests, replies or feedback, or is
            // being created.
            let post = || self.matches.post(writer).is_some_and(|post| post.is_acknowledged());
            line.unwrap_or_else(post)
        });
        self.meetings = meetings;
        ready.into_iter().for_each(|(writer, reader)| self.met(lines, writer, reader));
    }
}
