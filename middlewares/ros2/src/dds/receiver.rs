//! The thread that takes samples from DDS readers and events from DDS's discovery.

use std::cell::RefCell;
use std::collections::HashMap;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::{self, JoinHandle, ThreadId};

use crate::dds::rustdds::mio1::{Events, Interest, Poll, Token, Waker};
use crate::dds::rustdds::rpc::SampleIdentity;
use crate::dds::rustdds::{
    DomainParticipantStatusEvent, DomainParticipantStatusListener, GUID, StatusEvented, Timestamp,
};
use genom_kit::prompt::be_prompt;

use crate::dds::wire::{CopyTo, Reader};

const WAKE: Token = Token(0);
const STATUS: Token = Token(1);
const FIRST: usize = 2;

/// Samples taken from one reader in a row before it is the next one's turn.
const TURN: usize = 64;

/// A received sample.
#[derive(Debug)]
pub(crate) struct Sample<'a> {
    /// Header and payload. The receiver may swap the buffer for another.
    pub(crate) message: &'a mut Vec<u8>,
    pub(crate) writer: GUID,
    pub(crate) number: i64,
    /// Timestamp of the writer.
    pub(crate) stamp: Option<Timestamp>,
    /// When it was received.
    pub(crate) received: Timestamp,
    /// The request that this is a reply to.
    pub(crate) related: Option<SampleIdentity>,
}

/// Receives the samples of one reader.
pub(crate) trait Sink: Send {
    fn arrive(&mut self, sample: Sample<'_>);

    /// Called when all available samples have been taken.
    fn pause(&mut self) {}

    /// Called for a sample whose representation is not plain CDR.
    fn garbled(&mut self) {}
}

/// Receives discovery events.
pub(crate) type News = Box<dyn FnMut(DomainParticipantStatusEvent) + Send>;

enum Order {
    Add(Token, Box<Reader>, Box<dyn Sink>),
    /// From now on the sink gets the samples of another reader.
    Exchange(Token, Box<Reader>),
    Remove(Token, Sender<()>),
    Stop,
}

/// Owns the thread.
pub(crate) struct Inlet {
    orders: Sender<Order>,
    waker: Arc<Waker>,
    next: AtomicUsize,
    thread: Option<JoinHandle<()>>,
    id: ThreadId,
}

impl Inlet {
    pub(crate) fn start(
        mut status: DomainParticipantStatusListener,
        news: News,
    ) -> io::Result<Self> {
        let poll = Poll::new()?;
        let waker = Arc::new(Waker::new(poll.registry(), WAKE)?);
        poll.registry().register(status.as_status_source_mio1(), STATUS, Interest::READABLE)?;
        let (orders, receiver) = channel();
        let mut work = Work {
            poll,
            status,
            news,
            orders: receiver,
            readers: HashMap::new(),
            buffer: RefCell::default(),
            waker: Arc::clone(&waker),
        };
        let thread =
            thread::Builder::new().name("ros2-receiver".to_owned()).spawn(move || work.go_on())?;
        let id = thread.thread().id();
        Ok(Self { orders, waker, next: AtomicUsize::new(FIRST), thread: Some(thread), id })
    }

    fn order(&self, order: Order) {
        // Fails when the thread has ended; the order is dropped then.
        let _ = self.orders.send(order);
        let _ = self.waker.wake();
    }

    /// Passes the samples of a reader to a sink until it is removed.
    pub(crate) fn add(&self, reader: Reader, sink: Box<dyn Sink>) -> Token {
        let token = Token(self.next.fetch_add(1, Ordering::Relaxed));
        self.order(Order::Add(token, Box::new(reader), sink));
        token
    }

    /// Passes the samples of another reader to a sink, and ends the one it had.
    pub(crate) fn exchange(&self, token: Token, reader: Reader) {
        self.order(Order::Exchange(token, Box::new(reader)));
    }

    /// Ends a reader. When this returns, its sink gets no more calls, unless called on the thread
    /// itself.
    pub(crate) fn remove(&self, token: Token) {
        let (done, finished) = channel();
        self.order(Order::Remove(token, done));
        if thread::current().id() != self.id {
            // Returns when the order was carried out, or dropped together with the thread.
            let _ = finished.recv();
        }
    }
}

impl Drop for Inlet {
    fn drop(&mut self) {
        self.order(Order::Stop);
        let thread = self.thread.take().filter(|_| thread::current().id() != self.id);
        // A panic of the thread has been reported already.
        let _ = thread.map(JoinHandle::join);
    }
}

struct Work {
    poll: Poll,
    status: DomainParticipantStatusListener,
    news: News,
    orders: Receiver<Order>,
    readers: HashMap<Token, (Box<Reader>, Box<dyn Sink>)>,
    /// Buffer for the current sample.
    buffer: RefCell<Vec<u8>>,
    waker: Arc<Waker>,
}

impl Work {
    fn go_on(&mut self) {
        // Otherwise this thread would run only after DDS's thread has also sent its
        // acknowledgements.
        if let Err(error) = be_prompt() {
            tracing::debug!(%error, "samples may wait for their turn to be received");
        }
        let mut events = Events::with_capacity(256);
        // Readers that may have more samples than were taken in one turn.
        let mut again = Vec::new();
        loop {
            if let Err(error) = self.poll.poll(&mut events, None)
                && error.kind() != io::ErrorKind::Interrupted
            {
                tracing::error!(%error, "ros2 receives nothing any more");
                return;
            }
            let mut ready = std::mem::take(&mut again);
            let (mut is_news, mut is_order) = (false, false);
            for event in &events {
                match event.token() {
                    STATUS => is_news = true,
                    WAKE => is_order = true,
                    token => ready.push(token),
                }
            }
            // Each check costs system calls, so it is made only after an event.
            while is_news && let Some(event) = self.status.try_recv_status() {
                (self.news)(event);
            }
            if is_order && !self.carry_out(&mut ready) {
                return;
            }
            for token in ready {
                if self.take(token) {
                    again.push(token);
                }
            }
            if !again.is_empty() {
                // More to do: return here after checking for orders and events.
                let _ = self.waker.wake();
            }
        }
    }

    /// Carries out orders, and adds readers that may already have samples to `ready`. Returns false
    /// at the end.
    fn carry_out(&mut self, ready: &mut Vec<Token>) -> bool {
        while let Ok(order) = self.orders.try_recv() {
            match order {
                Order::Add(token, reader, sink) => ready.extend(self.add(token, reader, sink)),
                Order::Exchange(token, reader) => {
                    // The new reader also finds the samples that the old one still has.
                    if let Some((mut old, sink)) = self.readers.remove(&token) {
                        let _ = self.poll.registry().deregister(&mut *old);
                        ready.extend(self.add(token, reader, sink));
                    }
                }
                Order::Remove(token, done) => {
                    if let Some((mut reader, _sink)) = self.readers.remove(&token) {
                        // The reader is dropped in any case.
                        let _ = self.poll.registry().deregister(&mut *reader);
                    }
                    let _ = done.send(());
                }
                Order::Stop => return false,
            }
        }
        true
    }

    fn add(&mut self, token: Token, mut reader: Box<Reader>, sink: Box<dyn Sink>) -> Option<Token> {
        let registered = self.poll.registry().register(&mut *reader, token, Interest::READABLE);
        if let Err(error) = registered {
            tracing::error!(%error, "ros2 cannot wait for samples");
            return None;
        }
        self.readers.insert(token, (reader, sink));
        Some(token)
    }

    /// Takes the samples of a reader. Returns whether there may be more.
    fn take(&mut self, token: Token) -> bool {
        let Some((reader, sink)) = self.readers.get_mut(&token) else { return false };
        // Draining a notification takes longer than taking a sample, so the first sample is taken
        // before it. What arrives after the drain notifies again.
        take_one(reader, &mut **sink, &self.buffer);
        reader.drain_read_notifications();
        let more = (0..TURN).all(|_| take_one(reader, &mut **sink, &self.buffer));
        if !more {
            sink.pause();
        }
        more
    }
}

/// Takes a sample, if there is one. Returns whether there was.
fn take_one(reader: &mut Reader, sink: &mut dyn Sink, buffer: &RefCell<Vec<u8>>) -> bool {
    match reader.try_take_one_with(CopyTo(buffer)) {
        Ok(Some(taken)) => sink.arrive(Sample {
            message: &mut buffer.borrow_mut(),
            writer: taken.writer_guid,
            number: i64::from(taken.sequence_number),
            stamp: taken.source_timestamp(),
            received: taken.receive_instant,
            related: taken.related_sample_identity(),
        }),
        Ok(None) => return false,
        Err(_) => sink.garbled(),
    }
    true
}
