//! The one thread that sends: samples of out ports, what the daemon tells of itself, replies.
//!
//! Real-time threads fill a mailbox and ring; what DDS's calls cost or wait for is paid here.

use std::collections::HashMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle, ThreadId};
use std::time::{Duration, Instant};

use genom_middleware::bell::Bell;
use genom_middleware::mailbox::Mailbox;
use genom_middleware::spares::Spares;
use rustdds::bytes::Bytes;
use rustdds::{GUID, RTPSEntity, Timestamp};

use crate::complaints::BETWEEN_LINES;
use crate::feed::{Feed, Feeds};
use crate::meetings::{self, Meetings};
use crate::numbering::Numbering;
use crate::post::Matches;
use crate::wire::{HEADER, Payload, Writer};

/// Messages of one port sent in a row, before others have their turn.
const TURN: usize = 8;

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

/// Something to do on the thread.
pub(crate) type Job = Box<dyn FnOnce() + Send>;

/// Whether a reader is gone.
pub(crate) type Gone = Box<dyn Fn(&GUID) -> bool + Send>;

enum Order {
    Run(Job),
    Add(Box<Line>),
    Remove(GUID, Sender<()>),
    /// Others shall know of a change before anything else happens.
    Announce(Sender<()>),
    /// DDS has connected a writer of ours and a reader.
    Meet(GUID, GUID),
    /// Readers are gone: those the function tells.
    Part(Gone),
    /// This daemon begins to read a topic.
    Offer(Arc<Feed>),
    Stop,
}

/// What the real-time end of an out port and the thread share.
#[derive(Debug)]
pub(crate) struct Outlet {
    pub(crate) mailbox: Mailbox,
    /// Bytes to make ready for a message.
    pub(crate) room: usize,
    pub(crate) waits: AtomicBool,
    /// Samples DDS refused.
    pub(crate) refused: AtomicU64,
}

/// An out port as the thread sees it.
struct Line {
    writer: Writer,
    numbering: Numbering,
    topic: String,
    /// In ports of this daemon: DDS shows a participant to itself only over multicast.
    feeds: Arc<Feeds>,
    outlet: Arc<Outlet>,
    spares: Spares,
    /// For readers that come later.
    last: Option<Bytes>,
}

/// Gives orders to the thread; clones give them to the same one.
#[derive(Clone)]
pub(crate) struct Orders {
    sender: Sender<Order>,
    bell: Arc<Bell>,
    /// Whether there is something to announce.
    news: Arc<AtomicBool>,
    /// Whether in ports could not decode something.
    complaints: Arc<AtomicBool>,
    thread: ThreadId,
}

/// Owns the thread.
pub(crate) struct Worker {
    pub(crate) orders: Orders,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    pub(crate) fn start(announce: Box<dyn Announce>, matches: Arc<Matches>) -> io::Result<Self> {
        let (sender, receiver) = channel();
        let bell = Arc::new(Bell::default());
        let news = Arc::new(AtomicBool::new(false));
        let complaints = Arc::new(AtomicBool::new(false));
        let mut work = Work {
            receiver,
            bell: Arc::clone(&bell),
            lines: HashMap::new(),
            meetings: Meetings::default(),
            matches,
            announce,
            news: Arc::clone(&news),
            announced: None,
            complaints: Arc::clone(&complaints),
            complained: None,
        };
        let thread =
            thread::Builder::new().name("ros2-sender".to_owned()).spawn(move || work.go_on())?;
        let orders = Orders { sender, bell, news, complaints, thread: thread.thread().id() };
        Ok(Self { orders, thread: Some(thread) })
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.orders.order(Order::Stop);
        let thread = self.thread.take().filter(|_| !self.orders.on_thread());
        // A thread that panicked has been reported by its panic.
        let _ = thread.map(JoinHandle::join);
    }
}

impl Orders {
    fn on_thread(&self) -> bool {
        thread::current().id() == self.thread
    }

    fn order(&self, order: Order) {
        // After the end there is nothing left to do it with.
        let _ = self.sender.send(order);
        self.bell.ring();
    }

    /// Has others told of a change, soon.
    pub(crate) fn announce(&self) {
        self.news.store(true, Ordering::Release);
        self.bell.ring();
    }

    /// Has it told that an in port could not decode something. Wait-free.
    pub(crate) fn complain(&self) {
        self.complaints.store(true, Ordering::Release);
        self.bell.ring();
    }

    /// Has others told of a change, and waits a while until they know.
    pub(crate) fn announce_now(&self) {
        let (done, finished) = channel();
        self.order(Order::Announce(done));
        if !self.on_thread() {
            // Ends when the order was carried out, or dropped with the thread.
            let _ = finished.recv();
        }
    }

    /// Has a job done soon, after all that was ordered before.
    pub(crate) fn submit(&self, job: impl FnOnce() + Send + 'static) {
        self.order(Order::Run(Box::new(job)));
    }

    /// Has a job done and waits for it, except on the thread itself.
    pub(crate) fn finish(&self, job: impl FnOnce() + Send + 'static) {
        let (done, finished) = channel();
        self.submit(move || {
            job();
            let _ = done.send(());
        });
        if !self.on_thread() {
            // Ends when the job did, or was dropped with the thread.
            let _ = finished.recv();
        }
    }

    /// Adds an out port.
    pub(crate) fn add(
        &self,
        writer: Writer,
        topic: String,
        outlet: Arc<Outlet>,
        feeds: Arc<Feeds>,
    ) {
        let spares = Spares::new(outlet.room);
        let numbering = Numbering::default();
        let line = Line { writer, numbering, topic, feeds, outlet, spares, last: None };
        self.order(Order::Add(Box::new(line)));
    }

    /// Gives a topic that is read from now on the last value of this daemon's own out port.
    pub(crate) fn offer(&self, feed: Arc<Feed>) {
        self.order(Order::Offer(feed));
    }

    /// Sends what an out port still has, and takes it away.
    pub(crate) fn remove(&self, writer: GUID) {
        let (done, finished) = channel();
        self.order(Order::Remove(writer, done));
        if !self.on_thread() {
            // Ends when the order was carried out, or dropped with the thread.
            let _ = finished.recv();
        }
    }

    /// DDS has connected a writer of ours and a reader.
    pub(crate) fn meet(&self, writer: GUID, reader: GUID) {
        self.order(Order::Meet(writer, reader));
    }

    /// DDS has lost readers.
    pub(crate) fn part(&self, gone: impl Fn(&GUID) -> bool + Send + 'static) {
        self.order(Order::Part(Box::new(gone)));
    }

    /// Says that an out port has something to send. Wait-free.
    pub(crate) fn mark(&self, outlet: &Outlet) {
        outlet.waits.store(true, Ordering::Release);
        self.bell.ring();
    }
}

impl Line {
    /// Sends one message, if there is one.
    fn send(&mut self) -> bool {
        let writer = self.writer.guid();
        let Some(message) = self.spares.take(&self.outlet.mailbox) else { return false };
        for handle in self.feeds.of(&self.topic) {
            handle.feed.hear(writer, message.as_ref());
        }
        let message = Bytes::from_owner(message);
        let payload = message.slice(HEADER.min(message.len())..);
        self.last = Some(payload.clone());
        let options = self.numbering.next(Timestamp::now());
        if let Err(error) = self.writer.write_with_options(Payload(payload), options) {
            self.outlet.refused.fetch_add(1, Ordering::Relaxed);
            tracing::debug!(%error, "DDS refused a sample");
        }
        true
    }

    fn greet(&mut self, reader: GUID) {
        let Some(payload) = &self.last else { return };
        let before = self.numbering;
        let options = self.numbering.again(reader);
        if self.writer.write_with_options(Payload(payload.clone()), options).is_err() {
            // It was given no number.
            self.numbering = before;
            tracing::debug!("DDS refused the last value of a port");
        }
    }
}

struct Work {
    receiver: Receiver<Order>,
    bell: Arc<Bell>,
    lines: HashMap<GUID, Line>,
    meetings: Meetings,
    matches: Arc<Matches>,
    announce: Box<dyn Announce>,
    news: Arc<AtomicBool>,
    announced: Option<Instant>,
    complaints: Arc<AtomicBool>,
    complained: Option<Instant>,
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
    fn met(&mut self, writer: GUID, reader: GUID) {
        match self.matches.matched(writer, reader) {
            Some(post) => post.go_on(),
            None => _ = self.lines.get_mut(&writer).map(|line| line.greet(reader)),
        }
    }

    fn look_at_meetings(&mut self) {
        let ready = self.meetings.ready(|writer| match self.lines.get(writer) {
            Some(line) => meetings::acknowledged(&line.writer),
            // One that is not known is being made.
            None => self.matches.post(writer).is_some_and(|post| post.is_acknowledged()),
        });
        ready.into_iter().for_each(|(writer, reader)| self.met(writer, reader));
    }

    fn go_on(&mut self) {
        loop {
            let pauses = [self.until_announcement(), self.until_complaint(), self.meetings.pause()];
            self.bell.wait(pauses.into_iter().flatten().min());
            while let Ok(order) = self.receiver.try_recv() {
                match order {
                    Order::Run(job) => job(),
                    Order::Add(line) => _ = self.lines.insert(line.writer.guid(), *line),
                    Order::Remove(writer, done) => {
                        if let Some(mut line) = self.lines.remove(&writer) {
                            while line.send() {}
                            // Readers that are gone without a word are not waited for any longer.
                            let _ = line.writer.wait_for_acknowledgments(FAREWELL);
                        }
                        let _ = done.send(());
                    }
                    Order::Meet(writer, reader) => {
                        if self.meetings.begin(writer, reader) {
                            self.met(writer, reader);
                        }
                    }
                    Order::Part(gone) => {
                        self.meetings.lost(&gone);
                        self.matches.lost(&gone);
                    }
                    Order::Announce(done) => {
                        if self.announce.tell() {
                            self.announce.settle(FAREWELL);
                        }
                        let _ = done.send(());
                    }
                    Order::Offer(feed) => {
                        let line = self.lines.values().find(|line| line.topic == feed.topic);
                        if let Some((line, payload)) =
                            line.and_then(|line| Some((line, line.last.as_ref()?)))
                        {
                            let message = [&genom_types::cdr::HEADER[..], payload].concat();
                            feed.hear_first(line.writer.guid(), &message);
                        }
                    }
                    Order::Stop => return,
                }
            }
            self.look_at_meetings();
            for line in self.lines.values_mut() {
                if !line.outlet.waits.swap(false, Ordering::Acquire) {
                    continue;
                }
                if (0..TURN).all(|_| line.send()) {
                    line.outlet.waits.store(true, Ordering::Relaxed);
                    self.bell.ring();
                }
            }
        }
    }
}
