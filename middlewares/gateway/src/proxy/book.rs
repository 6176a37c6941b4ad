//! What a proxy has open, and what it waits for.

use std::collections::{BTreeMap, HashMap};
use std::os::unix::net::UnixStream;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError, sync_channel};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

use genom_kit::sender::Orders;
use genom_middleware::{CallError, OnRequest, Outcome, Replies, ServiceHandler, ServiceType};
use genom_types::DataType;

use super::lines::{Inbox, Line, Lost};
use crate::channel::{Channel, NotQueued, Outgoing, lock};
use crate::place::Reach;
use crate::wire;
use crate::words::{About, Answer, Question, Refusal, Up, What};

/// How long it may take to open an end: middlewares look for others first.
const OPENING: Duration = Duration::from_secs(30);

/// How long whoever closes an end waits until it is closed.
const CLOSING: Duration = Duration::from_secs(5);

/// How long an answer may take.
const ANSWER: Duration = Duration::from_secs(10);

/// How long a question waits for a gateway that is being started again.
const RETURN: Duration = Duration::from_secs(1);

/// Between two attempts to open an end again that a new gateway refuses: the first pause, and the
/// longest.
const AGAIN: (Duration, Duration) = (Duration::from_millis(50), Duration::from_secs(2));

/// Requests that may be under way at once.
const CALLS: usize = 1 << 16;

/// What the threads of a proxy share.
pub(crate) struct Shared {
    pub(crate) name: &'static str,
    pub(crate) reach: Reach,
    pub(crate) channel: Arc<Channel>,
    pub(crate) book: Mutex<Book>,
    /// Signalled when the gateway comes or goes.
    pub(crate) changed: Condvar,
    pub(crate) orders: OnceLock<Orders<Outgoing<Line>>>,
    pub(crate) stop: AtomicBool,
    /// What the hearing thread waits on, so that it can be shut down.
    pub(crate) waits_on: Mutex<Option<UnixStream>>,
    pub(crate) rings: AtomicBool,
    pub(crate) hearing: OnceLock<ThreadId>,
    numbers: AtomicU64,
}

/// All that is open. No callback is called while it is locked.
#[derive(Default)]
pub(crate) struct Book {
    /// Counts the connections.
    pub(crate) generation: u64,
    /// Whether there is one now.
    pub(crate) up: bool,
    /// Why there is none.
    pub(crate) why: Option<String>,
    /// The daemon itself says so.
    pub(crate) refused: bool,
    pub(crate) about: Option<About>,
    pub(crate) ends: HashMap<u32, End>,
    /// Ends that are being closed.
    pub(crate) closing: HashMap<u32, SyncSender<()>>,
    /// Those that the thread closed which would hear of it, and could not wait for.
    unheard: Vec<Receiver<()>>,
    pub(crate) calls: HashMap<u64, Call>,
    pub(crate) questions: HashMap<u64, SyncSender<(Answer, Vec<u8>)>>,
    /// Foreign names, by full name of the type or service.
    pub(crate) masks: BTreeMap<String, String>,
    /// Ends that the gateway refused, and when to try again.
    pub(crate) again: Vec<(Instant, u32)>,
}

/// An end.
pub(crate) struct End {
    /// The message that opens it, as a frame.
    open: Vec<u8>,
    pub(crate) kind: Kind,
    /// Who waits until it is open for the first time.
    pub(crate) opening: Option<SyncSender<Result<(), Refusal>>>,
    /// Pause before the next attempt to open it again.
    pub(crate) pause: Duration,
}

/// What arrives for an end goes there.
#[derive(Clone)]
pub(crate) enum Kind {
    Publisher { line: usize, live: Arc<AtomicBool>, lost: Arc<Lost> },
    Subscription(Arc<Inbox>),
    Served(ServiceType, Arc<dyn ServiceHandler>),
    Client,
    Announcement(Arc<OnRequest>),
}

/// A request under way.
#[derive(Clone)]
pub(crate) struct Call {
    pub(crate) replies: Arc<Mutex<Option<Box<dyn Replies>>>>,
    pub(crate) output: DataType,
}

impl Call {
    pub(crate) fn finish(&self, outcome: Outcome) {
        let replies = lock(&self.replies).take();
        if let Some(replies) = replies {
            replies.finish(outcome);
        }
    }
}

/// Why a question has no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NoAnswer {
    /// There is no gateway now.
    #[error("{0}")]
    Down(String),
    #[error("its gateway does not keep up")]
    Full,
    #[error("its gateway does not answer")]
    Late,
    #[error("its gateway has ended")]
    Gone,
    /// It answers something else.
    #[error("its gateway is of another version")]
    Misread,
}

impl Shared {
    pub(crate) fn new(name: &'static str, reach: Reach) -> Self {
        Self {
            name,
            reach,
            channel: Arc::default(),
            book: Mutex::default(),
            changed: Condvar::new(),
            orders: OnceLock::new(),
            stop: AtomicBool::new(false),
            waits_on: Mutex::default(),
            rings: AtomicBool::new(false),
            hearing: OnceLock::new(),
            numbers: AtomicU64::new(1),
        }
    }

    pub(crate) fn number(&self) -> u64 {
        self.numbers.fetch_add(1, Ordering::Relaxed)
    }

    pub(crate) fn ring(&self) {
        if let Some(orders) = self.orders.get() {
            orders.ring();
        }
    }

    pub(crate) fn about<T>(&self, of: impl FnOnce(&crate::words::About) -> T) -> Option<T> {
        lock(&self.book).about.as_ref().map(of)
    }

    /// Queues a message for the gateway of this generation.
    pub(crate) fn say_in(&self, generation: u64, up: &Up, payload: &[u8]) -> Result<(), NotQueued> {
        let put = self.channel.put(generation, up, payload);
        self.ring();
        put
    }

    /// Queues a message for the gateway that there is now.
    pub(crate) fn say(&self, up: &Up, payload: &[u8]) -> Result<(), NotQueued> {
        let generation = {
            let book = lock(&self.book);
            if book.up { book.generation } else { 0 }
        };
        self.say_in(generation, up, payload)
    }

    /// Why a request fails while there is no gateway.
    pub(crate) fn down(&self, book: &Book) -> String {
        let why = book.why.as_deref().unwrap_or("it has not been reached yet");
        format!("its gateway does not answer ({why}): `genomctl cells` tells how it is")
    }

    pub(crate) fn failed(&self, why: impl Into<String>) -> CallError {
        CallError::Failed { backend: self.name.to_owned(), why: why.into() }
    }

    /// Asks the gateway, and waits for the answer.
    pub(crate) fn ask(
        &self,
        question: &Question,
        payload: &[u8],
    ) -> Result<(Answer, Vec<u8>), NoAnswer> {
        let more = match question {
            Question::Ask { patience, .. } => *patience,
            _ => Duration::ZERO,
        };
        let (told, answer) = sync_channel(1);
        let number = self.number();
        {
            let mut book = lock(&self.book);
            let end = Instant::now() + RETURN;
            while !book.up {
                let left = end.saturating_duration_since(Instant::now());
                if left.is_zero() {
                    return Err(NoAnswer::Down(self.down(&book)));
                }
                let waited = self.changed.wait_timeout(book, left);
                book = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
            let words = QuestionRef { number, question };
            let put = self.channel.put(book.generation, &Asking::Question(words), payload);
            if put.is_err() {
                return Err(NoAnswer::Full);
            }
            book.questions.insert(number, told);
        }
        self.ring();
        let answered = answer.recv_timeout(ANSWER + more);
        lock(&self.book).questions.remove(&number);
        answered.map_err(|error| match error {
            RecvTimeoutError::Timeout => NoAnswer::Late,
            RecvTimeoutError::Disconnected => NoAnswer::Gone,
        })
    }

    /// Registers a request, and sends it.
    pub(crate) fn call(&self, end: u32, call: Call, input: &[u8]) -> Result<u64, CallError> {
        let number = self.number();
        {
            let mut book = lock(&self.book);
            if !book.up {
                return Err(self.failed(self.down(&book)));
            }
            let full = book.calls.len() >= CALLS;
            let up = Up::Request { end, call: number };
            if full || self.channel.put(book.generation, &up, input).is_err() {
                return Err(self.failed("too many requests are under way"));
            }
            book.calls.insert(number, call);
        }
        self.ring();
        Ok(number)
    }

    /// Opens an end, and waits until it is.
    pub(crate) fn open(&self, end: u32, what: What, kind: Kind) -> Result<(), Refusal> {
        let own = |why: String| Refusal::Own(why);
        let open = wire::message(&Up::Open { end, what }, &[]);
        let open = open.map_err(|error| own(error.to_string()))?;
        let (told, opening) = sync_channel(1);
        {
            let mut book = lock(&self.book);
            let entry = End { open: open.clone(), kind, opening: Some(told), pause: AGAIN.0 };
            book.ends.insert(end, entry);
            if book.up {
                // If it does not fit, nobody answers within the limit.
                let _ = self.channel.put_frame(book.generation, open);
            }
        }
        self.ring();
        // A gateway that ends meanwhile is asked again when it is back.
        match opening.recv_timeout(OPENING) {
            Ok(Ok(())) => Ok(()),
            Ok(Err(why)) => Err(why),
            Err(_) => {
                // Dropped without the lock: a handler of requests may have ends of its own.
                let gone;
                let why = {
                    let mut book = lock(&self.book);
                    gone = book.ends.remove(&end);
                    if book.up { "its gateway does not answer".into() } else { self.down(&book) }
                };
                drop(gone);
                let _ = self.say(&Up::Close { end }, &[]);
                Err(own(why))
            }
        }
    }

    /// Closes an end. Waits until it is closed, so that its address is free, but not on the thread
    /// that would hear of it: that one drops a handler of requests, and the ends that it has of its
    /// own, if the service is closed while it calls the handler. Whoever closed the service waits for
    /// these, too.
    pub(crate) fn close(&self, end: u32) {
        let (told, closed) = sync_channel(1);
        // Dropped without the lock: a handler of requests may have ends of its own.
        let gone;
        {
            let mut book = lock(&self.book);
            gone = book.ends.remove(&end);
            if !book.up || self.channel.put(book.generation, &Up::Close { end }, &[]).is_err() {
                return;
            }
            book.closing.insert(end, told);
        }
        drop(gone);
        self.ring();
        if self.hearing.get() == Some(&thread::current().id()) {
            let mut book = lock(&self.book);
            book.unheard.retain(|closed| closed.try_recv() == Err(TryRecvError::Empty));
            book.unheard.push(closed);
            return;
        }
        let _ = closed.recv_timeout(CLOSING);
        let unheard = {
            let mut book = lock(&self.book);
            book.closing.remove(&end);
            std::mem::take(&mut book.unheard)
        };
        for closed in unheard {
            let _ = closed.recv_timeout(CLOSING);
        }
    }

    /// A gateway is there: opens all ends in it.
    pub(crate) fn comes(&self, stream: UnixStream, about: About) {
        let mut book = lock(&self.book);
        book.generation += 1;
        let generation = book.generation;
        self.channel.open(stream, generation);
        for (ours, foreign) in &book.masks {
            let (ours, foreign) = (ours.clone(), Some(foreign.clone()));
            let _ = self.channel.put(generation, &Up::Mask { ours, foreign }, &[]);
        }
        book.again.clear();
        for end in book.ends.values_mut() {
            end.pause = AGAIN.0;
            let _ = self.channel.put_frame(generation, end.open.clone());
        }
        (book.up, book.refused, book.why, book.about) = (true, false, None, Some(about));
        drop(book);
        self.changed.notify_all();
        self.ring();
    }

    /// The gateway is gone: ends what waits for it. Its stream is shut down already.
    pub(crate) fn goes(&self, why: String) {
        self.channel.close();
        let mut book = lock(&self.book);
        book.up = false;
        book.why = Some(why);
        for end in book.ends.values() {
            match &end.kind {
                Kind::Publisher { live, lost, .. } => {
                    live.store(false, Ordering::SeqCst);
                    lost.settle();
                }
                Kind::Subscription(inbox) => inbox.lost.settle(),
                _ => {}
            }
        }
        // Whoever waits for one of these sees that nobody answers.
        book.closing.clear();
        book.questions.clear();
        let calls = std::mem::take(&mut book.calls);
        drop(book);
        self.changed.notify_all();
        for call in calls.into_values() {
            let why = "its gateway ended while the request was under way: whether it was done is \
                       unknown";
            call.finish(Outcome::Lost(self.failed(why)));
        }
    }

    /// Opens the ends again that the gateway refused and whose turn has come; returns when the next
    /// one's comes.
    pub(crate) fn open_again(&self) -> Option<Duration> {
        let mut book = lock(&self.book);
        if !book.up || book.again.is_empty() {
            return None;
        }
        let now = Instant::now();
        let (due, later): (Vec<_>, Vec<_>) =
            std::mem::take(&mut book.again).into_iter().partition(|(when, _)| *when <= now);
        for (_, end) in due {
            let Some(open) = book.ends.get(&end).map(|end| end.open.clone()) else { continue };
            let _ = self.channel.put_frame(book.generation, open);
        }
        let next = later.iter().map(|(when, _)| when.saturating_duration_since(now)).min();
        book.again = later;
        next
    }

    /// An end was refused that is to be open: when to try again. Returns whether to tell.
    pub(crate) fn try_again(&self, book: &mut Book, number: u32) -> bool {
        let Some(end) = book.ends.get_mut(&number) else { return false };
        let (pause, first) = (end.pause, end.pause == AGAIN.0);
        end.pause = (pause * 2).min(AGAIN.1);
        book.again.push((Instant::now() + pause, number));
        first
    }
}

#[derive(serde::Serialize)]
struct QuestionRef<'a> {
    number: u64,
    question: &'a Question,
}

/// Spelled as [`Up::Question`].
#[derive(serde::Serialize)]
enum Asking<'a> {
    Question(QuestionRef<'a>),
}
