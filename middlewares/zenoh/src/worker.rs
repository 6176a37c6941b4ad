//! The one thread of a session that sends: samples of out ports, replies, questions.
//!
//! Real-time threads fill a mailbox and ring; what zenoh's calls cost or wait for is paid here.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle, ThreadId};

use bytes::Bytes;
use genom_middleware::bell::Bell;
use genom_middleware::mailbox::Mailbox;
use genom_middleware::prompt::be_prompt;
use genom_middleware::spares::Spares;
use zenoh::bytes::ZBytes;
use zenoh::pubsub::Publisher;
use zenoh::{Session, Wait};

use crate::wire::Mark;

/// Words of the bit set of ports that have something to send.
const WORDS: usize = 64;

/// Bits of all words. Ports share one when there are more.
const BITS: usize = WORDS * 64;

/// Messages of one port sent in a row, before others have their turn.
const TURN: usize = 8;

/// Something to do on the thread.
pub(crate) type Job = Box<dyn FnOnce(&mut Outgoing) + Send>;

enum Order {
    Run(Job),
    Stop,
}

/// What the thread owns.
pub(crate) struct Outgoing {
    pub(crate) session: Session,
    lines: Vec<Option<Line>>,
}

/// An out port as the thread sees it.
pub(crate) struct Line {
    pub(crate) publisher: Publisher<'static>,
    pub(crate) mailbox: Arc<Mailbox>,
    pub(crate) spares: Spares,
    pub(crate) last: Arc<LastValue>,
    /// Mark of the sample sent last.
    pub(crate) mark: Mark,
    /// Samples zenoh refused.
    pub(crate) refused: Arc<AtomicU64>,
}

/// What late readers get: payload and attachment.
#[derive(Debug, Default)]
pub(crate) struct LastValue(Mutex<Option<(ZBytes, Mark)>>);

/// Gives orders to the thread; clones give them to the same one.
#[derive(Clone)]
pub(crate) struct Orders {
    sender: Sender<Order>,
    bell: Arc<Bell>,
    dirty: Arc<[AtomicU64]>,
    /// Numbers of lines that are free, and the first one never used.
    free: Arc<Mutex<(Vec<usize>, usize)>>,
    thread: ThreadId,
}

/// Owns the thread.
pub(crate) struct Worker {
    pub(crate) orders: Orders,
    thread: Option<JoinHandle<()>>,
}

impl LastValue {
    pub(crate) fn get(&self) -> Option<(ZBytes, Mark)> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn set(&self, payload: ZBytes, mark: Mark) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((payload, mark));
    }
}

impl Worker {
    pub(crate) fn start(session: Session) -> std::io::Result<Self> {
        let (sender, receiver) = channel();
        let bell = Arc::new(Bell::default());
        let dirty: Arc<[AtomicU64]> = (0..WORDS).map(|_| AtomicU64::new(0)).collect();
        let mut work = Work {
            outgoing: Outgoing { session, lines: Vec::new() },
            receiver,
            bell: Arc::clone(&bell),
            dirty: Arc::clone(&dirty),
        };
        let thread =
            thread::Builder::new().name("zenoh-sender".to_owned()).spawn(move || work.go_on())?;
        let orders =
            Orders { sender, bell, dirty, free: Arc::default(), thread: thread.thread().id() };
        Ok(Self { orders, thread: Some(thread) })
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        let _ = self.orders.sender.send(Order::Stop);
        self.orders.bell.ring();
        let thread = self.thread.take().filter(|_| !self.orders.on_thread());
        // A thread that panicked has been reported by its panic.
        let _ = thread.map(JoinHandle::join);
    }
}

impl Orders {
    fn on_thread(&self) -> bool {
        thread::current().id() == self.thread
    }

    /// Has a job done soon, after all that was given before.
    pub(crate) fn submit(&self, job: impl FnOnce(&mut Outgoing) + Send + 'static) {
        // After the end there is nothing left to do it with.
        let _ = self.sender.send(Order::Run(Box::new(job)));
        self.bell.ring();
    }

    /// Has a job done and waits for it, except on the thread itself.
    pub(crate) fn finish(&self, job: impl FnOnce(&mut Outgoing) + Send + 'static) {
        let (done, finished) = channel();
        self.submit(move |outgoing| {
            job(outgoing);
            let _ = done.send(());
        });
        if !self.on_thread() {
            // Ends when the job did, or was dropped with the thread.
            let _ = finished.recv();
        }
    }

    /// Adds an out port; its number.
    pub(crate) fn add(&self, line: Line) -> usize {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let number = free.0.pop().unwrap_or_else(|| {
            free.1 += 1;
            free.1 - 1
        });
        drop(free);
        self.submit(move |outgoing| {
            if outgoing.lines.len() <= number {
                outgoing.lines.resize_with(number + 1, || None);
            }
            if let Some(place) = outgoing.lines.get_mut(number) {
                *place = Some(line);
            }
        });
        number
    }

    /// Says that an out port has something to send. Wait-free.
    pub(crate) fn mark(&self, line: usize) {
        if let Some(word) = self.dirty.get(line % BITS / 64) {
            word.fetch_or(1 << (line % 64), Ordering::Release);
        }
        self.bell.ring();
    }

    /// Sends what an out port still has, takes it away and drops what goes with it.
    pub(crate) fn remove(&self, line: usize, with: impl Send + 'static) {
        let free = Arc::clone(&self.free);
        self.finish(move |outgoing| {
            if let Some(mut line) = outgoing.lines.get_mut(line).and_then(Option::take) {
                while line.send() {}
            }
            drop(with);
            free.lock().unwrap_or_else(PoisonError::into_inner).0.push(line);
        });
    }
}

impl Line {
    /// Sends one message, if there is one.
    fn send(&mut self) -> bool {
        let Some(message) = self.spares.take(&self.mailbox) else { return false };
        let payload = ZBytes::from(Bytes::from_owner(message));
        self.mark.number += 1;
        // First for those who come, then for those who are there: nobody misses it.
        self.last.set(payload.clone(), self.mark);
        let put = self.publisher.put(payload).attachment(&self.mark.to_bytes()[..]);
        if let Err(error) = put.wait() {
            self.refused.fetch_add(1, Ordering::Relaxed);
            tracing::debug!(%error, key = %self.publisher.key_expr(), "zenoh refused a sample");
        }
        true
    }
}

struct Work {
    outgoing: Outgoing,
    receiver: Receiver<Order>,
    bell: Arc<Bell>,
    dirty: Arc<[AtomicU64]>,
}

impl Work {
    fn go_on(&mut self) {
        if let Err(error) = be_prompt() {
            tracing::debug!(%error, "samples may wait for their turn to be sent");
        }
        loop {
            self.bell.wait(None);
            while let Ok(order) = self.receiver.try_recv() {
                match order {
                    Order::Run(job) => job(&mut self.outgoing),
                    Order::Stop => return,
                }
            }
            for (index, word) in self.dirty.iter().enumerate() {
                // Most are clear, and a look costs less than an exchange.
                if word.load(Ordering::Relaxed) == 0 {
                    continue;
                }
                let mut bits = word.swap(0, Ordering::Acquire);
                while bits != 0 {
                    let bit = bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    if self.outgoing.send(index * 64 + bit) {
                        word.fetch_or(1 << bit, Ordering::Relaxed);
                        self.bell.ring();
                    }
                }
            }
        }
    }
}

impl Outgoing {
    /// Sends for the ports of one bit; whether some may have more.
    fn send(&mut self, bit: usize) -> bool {
        let mut more = false;
        for line in self.lines.iter_mut().skip(bit).step_by(BITS).flatten() {
            more |= (0..TURN).all(|_| line.send());
        }
        more
    }
}
