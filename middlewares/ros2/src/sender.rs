//! What the sending thread does: samples of out ports, what the daemon tells of itself, replies.

use std::collections::HashMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use genom_kit::lines::Lines;
use genom_kit::outlet::Outlet;
use genom_kit::sender::{self, Duty};
use rustdds::bytes::Bytes;
use rustdds::{GUID, RTPSEntity, Timestamp};

use crate::complaints::BETWEEN_LINES;
use crate::feed::Feed;
use crate::feeds::Feeds;
use crate::meetings::{self, Meetings};
use crate::numbering::Numbering;
use crate::post::Matches;
use crate::wire::{HEADER, Payload, Writer};

/// Longest time the last samples of a port that closes may take to arrive.
const FAREWELL: Duration = Duration::from_millis(100);

/// Time between two announcements of what changed: many changes at once are one.
const BETWEEN: Duration = Duration::from_millis(20);

/// Tells others what changed.
pub(crate) trait Announce: Send {
    /// Tells; false when it has to be done again.
    fn tell(&self) -> bool;

    /// Waits a while until others know.
    fn settle(&self, longest: Duration);

    /// Tells the log of samples that could not be decoded.
    fn complain(&self);
}

/// An out port as the thread sees it.
pub(crate) struct Line {
    writer: Writer,
    numbering: Numbering,
    topic: String,
    /// In ports of this daemon: DDS shows a participant to itself only over multicast.
    feeds: Arc<Feeds>,
    outlet: Arc<Outlet>,
    /// For readers that come later.
    last: Option<Bytes>,
}

/// Owns the thread.
pub(crate) struct Sending {
    _sender: sender::Sender<Work>,
    orders: Orders,
}

/// Gives orders to the thread; clones give them to the same one.
#[derive(Clone)]
pub(crate) struct Orders {
    thread: sender::Orders<Work>,
    /// Whether there is something to announce.
    news: Arc<AtomicBool>,
    /// Whether in ports could not decode something.
    complaints: Arc<AtomicBool>,
}

impl Sending {
    pub(crate) fn start(announce: Box<dyn Announce>, matches: Arc<Matches>) -> io::Result<Self> {
        let news = Arc::new(AtomicBool::new(false));
        let complaints = Arc::new(AtomicBool::new(false));
        let work = Work {
            lines: HashMap::new(),
            meetings: Meetings::default(),
            matches,
            announce,
            news: Arc::clone(&news),
            announced: None,
            complaints: Arc::clone(&complaints),
            complained: None,
        };
        // Not prompt: its first act is to wake the threads of DDS.
        let sender = sender::Sender::start("ros2", false, work)?;
        let thread = sender.orders().clone();
        Ok(Self { _sender: sender, orders: Orders { thread, news, complaints } })
    }

    pub(crate) fn orders(&self) -> &Orders {
        &self.orders
    }
}

impl Orders {
    /// Has others told of a change, soon.
    pub(crate) fn announce(&self) {
        self.news.store(true, Ordering::Release);
        self.thread.ring();
    }

    /// Has it told that an in port could not decode something. Wait-free.
    pub(crate) fn complain(&self) {
        self.complaints.store(true, Ordering::Release);
        self.thread.ring();
    }

    /// Has others told of a change, and waits a while until they know.
    pub(crate) fn announce_now(&self) {
        self.thread.finish(|work, _| {
            if work.announce.tell() {
                work.announce.settle(FAREWELL);
            }
        });
    }

    /// Has a job done soon, after all that was ordered before.
    pub(crate) fn submit(&self, job: impl FnOnce() + Send + 'static) {
        self.thread.submit(|_, _| job());
    }

    /// Has a job done and waits for it, except on the thread itself.
    pub(crate) fn finish(&self, job: impl FnOnce() + Send + 'static) {
        self.thread.finish(|_, _| job());
    }

    /// Adds an out port; its number.
    pub(crate) fn add(&self, line: Line) -> usize {
        let writer = line.writer.guid();
        let number = self.thread.add(line);
        self.thread.submit(move |work, _| _ = work.lines.insert(writer, number));
        number
    }

    /// Gives a topic that is read from now on the last value of this daemon's own out port.
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

    /// Sends what an out port still has, and takes it away.
    pub(crate) fn remove(&self, line: usize) {
        self.thread.remove(line, |work, line| {
            work.lines.remove(&line.writer.guid());
            // Readers that are gone without a word are not waited for any longer.
            let _ = line.writer.wait_for_acknowledgments(FAREWELL);
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

    /// Says that an out port has something to send. Wait-free.
    pub(crate) fn mark(&self, line: usize) {
        self.thread.mark(line);
    }

    /// Keeps the first out port from sending until the result is dropped.
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
        Self { writer, numbering, topic, feeds, outlet, last: None }
    }

    fn greet(&mut self, reader: GUID) {
        let Some(payload) = &self.last else { return };
        let before = self.numbering;
        let options = self.numbering.again(reader);
        if self.writer.write_with_options(Payload(payload.clone()), options).is_err() {
            // Nothing was sent, so no number was used.
            self.numbering = before;
            tracing::debug!("DDS refused the last value of a port");
        }
    }
}

impl sender::Line for Line {
    fn send(&mut self) -> bool {
        let writer = self.writer.guid();
        let Some(message) = self.outlet.take() else { return false };
        for handle in self.feeds.of(&self.topic) {
            handle.feed.hear(writer, message.as_ref());
        }
        let message = Bytes::from_owner(message);
        let payload = message.slice(HEADER.min(message.len())..);
        self.last = Some(payload.clone());
        let options = self.numbering.next(Timestamp::now());
        if let Err(error) = self.writer.write_with_options(Payload(payload), options) {
            self.outlet.refuse();
            tracing::debug!(%error, "DDS refused a sample");
        }
        true
    }
}

/// What jobs work with.
struct Work {
    /// Numbers of out ports.
    lines: HashMap<GUID, usize>,
    meetings: Meetings,
    matches: Arc<Matches>,
    announce: Box<dyn Announce>,
    news: Arc<AtomicBool>,
    announced: Option<Instant>,
    complaints: Arc<AtomicBool>,
    complained: Option<Instant>,
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
    /// Announces what is due, and says when to come back.
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

    /// Tells of bad samples when a line is due, and says when to come back.
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

    /// A reader is ready: it gets what waits for it, or the last value of the port.
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
            // A writer without a line is one of requests, replies or feedback, or is being made.
            let post = || self.matches.post(writer).is_some_and(|post| post.is_acknowledged());
            line.unwrap_or_else(post)
        });
        self.meetings = meetings;
        ready.into_iter().for_each(|(writer, reader)| self.met(lines, writer, reader));
    }
}
