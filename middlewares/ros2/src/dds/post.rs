//! Writers whose messages wait until the reader that they are for is connected.
//!
//! DDS delivers a volatile message only to readers that it knows already, so a reply that is sent
//! too early is lost. Requests, replies and feedback therefore wait here for their reader.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::Duration;

use crate::dds::rustdds::{GUID, RTPSEntity};

use crate::dds::meetings;
use crate::dds::wire::Writer;
use crate::rmw::Target;

/// Greatest number of waiting messages; the oldest are dropped.
const MOST: usize = 256;

/// First part of the GUIDs of all ends of a participant.
pub(crate) type Prefix = [u8; 12];

pub(crate) fn prefix(of: &GUID) -> Prefix {
    let mut prefix = Prefix::default();
    prefix.iter_mut().zip(of.to_bytes()).for_each(|(to, byte)| *to = byte);
    prefix
}

fn is(target: Target, reader: &GUID) -> bool {
    match target {
        Target::End(wanted) => reader.to_bytes() == wanted,
        Target::Beside(wanted) => prefix(reader) == prefix(&GUID::from_bytes(wanted)),
    }
}

/// Which readers our writers are connected to.
#[derive(Default)]
pub(crate) struct Matches(Mutex<Matched>);

#[derive(Default)]
struct Matched {
    readers: HashMap<GUID, HashSet<GUID>>,
    posts: HashMap<GUID, Weak<Post>>,
}

impl Matches {
    fn lock(&self) -> MutexGuard<'_, Matched> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The post that uses this writer, if it is one of requests, replies or feedback.
    pub(crate) fn post(&self, writer: &GUID) -> Option<Arc<Post>> {
        self.lock().posts.get(writer).and_then(Weak::upgrade)
    }

    /// A writer is connected to a reader. Returns the writer's post, whose messages can be sent
    /// now.
    pub(crate) fn matched(&self, writer: GUID, reader: GUID) -> Option<Arc<Post>> {
        let mut state = self.lock();
        state.readers.entry(writer).or_default().insert(reader);
        state.posts.get(&writer).and_then(Weak::upgrade)
    }

    /// Removes readers that are gone.
    pub(crate) fn lost(&self, gone: impl Fn(&GUID) -> bool) {
        let mut state = self.lock();
        state.readers.values_mut().for_each(|readers| readers.retain(|reader| !gone(reader)));
        let posts: Vec<_> = state.posts.values().filter_map(Weak::upgrade).collect();
        drop(state);
        posts.iter().for_each(|post| post.lost(&gone));
    }

    /// Removes a writer that is closed.
    pub(crate) fn forget(&self, writer: &GUID) {
        let mut state = self.lock();
        state.readers.remove(writer);
        state.posts.remove(writer);
    }

    fn reaches(&self, writer: &GUID, to: Target) -> bool {
        self.lock().readers.get(writer).into_iter().flatten().any(|reader| is(to, reader))
    }
}

/// Writes one message.
pub(crate) type Letter = Box<dyn FnOnce(&Writer) + Send>;

/// Called when readers are gone, with a function that tells who can still be reached.
pub(crate) type OnLost = Box<dyn Fn(&dyn Fn(Target) -> bool) + Send + Sync>;

/// A writer and its waiting messages. Used on the sending thread only, except for its creation.
pub(crate) struct Post {
    writer: Writer,
    matches: Arc<Matches>,
    waiting: Mutex<VecDeque<(Target, Letter)>>,
    on_lost: OnLost,
}

impl Post {
    pub(crate) fn new(writer: Writer, matches: &Arc<Matches>, on_lost: OnLost) -> Arc<Self> {
        meetings::prime(&writer);
        let waiting = Mutex::default();
        let post = Arc::new(Self { writer, matches: Arc::clone(matches), waiting, on_lost });
        matches.lock().posts.insert(post.guid(), Arc::downgrade(&post));
        post
    }

    pub(crate) fn guid(&self) -> GUID {
        self.writer.guid()
    }

    /// Writes a message to whoever is connected.
    pub(crate) fn now(&self, letter: Letter) {
        letter(&self.writer);
    }

    /// Writes a message as soon as its recipient is connected.
    pub(crate) fn send(&self, to: Target, letter: Letter) {
        if self.matches.reaches(&self.guid(), to) {
            return letter(&self.writer);
        }
        let mut waiting = self.lock();
        waiting.push_back((to, letter));
        let given_up = if waiting.len() > MOST { waiting.pop_front() } else { None };
        // Dropped after releasing the lock: dropping a letter may use this post.
        drop(waiting);
        drop(given_up);
    }

    /// Writes the waiting messages whose recipient is connected now.
    pub(crate) fn go_on(&self) {
        let guid = self.guid();
        let waiting = std::mem::take(&mut *self.lock());
        let (ready, rest): (Vec<_>, VecDeque<_>) = {
            let mut ready = Vec::new();
            let mut rest = VecDeque::new();
            for (to, letter) in waiting {
                if self.matches.reaches(&guid, to) {
                    ready.push(letter);
                } else {
                    rest.push_back((to, letter));
                }
            }
            (ready, rest)
        };
        let mut now = self.lock();
        let later = std::mem::replace(&mut *now, rest);
        now.extend(later);
        drop(now);
        ready.into_iter().for_each(|letter| letter(&self.writer));
    }

    /// Drops the messages to readers that are gone.
    fn lost(&self, gone: impl Fn(&GUID) -> bool) {
        let mut waiting = self.lock();
        let (given_up, rest) =
            std::mem::take(&mut *waiting).into_iter().partition::<VecDeque<_>, _>(
                |(to, _)| matches!(to, Target::End(of) if gone(&GUID::from_bytes(*of))),
            );
        *waiting = rest;
        // Dropped after releasing the lock: dropping a letter may use this post.
        drop(waiting);
        drop(given_up);
        (self.on_lost)(&|to| self.matches.reaches(&self.guid(), to));
    }

    /// Whether all readers know the writer and have received everything.
    pub(crate) fn is_acknowledged(&self) -> bool {
        meetings::acknowledged(&self.writer)
    }

    /// Waits for a limited time until everything written has arrived. Returns whether it has.
    pub(crate) fn settle(&self, longest: Duration) -> bool {
        meetings::acknowledged_in(&self.writer, longest)
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<(Target, Letter)>> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Post {
    fn drop(&mut self) {
        self.matches.forget(&self.writer.guid());
    }
}
