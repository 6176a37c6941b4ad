//! Lists that a library fills during a call.
//!
//! What the library gets is a number, not a pointer: a list that it adds to after the call, from a
//! thread of its own, is not found any more.

use std::collections::BTreeMap;
use std::ptr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use genom_kit::complaints::Complaints;
use genom_middleware::{Endpoint, Refused};
use genom_plugin_abi::table::Opaque;

/// Most bytes of a message between daemons.
pub(crate) const MESSAGE: usize = 64 << 20;

/// Most replies to one request.
const REPLIES: usize = 16;

/// Most entries of a list.
const ENTRIES: usize = 100_000;

/// Most bytes of all entries together.
const ROOM: usize = 128 << 20;

/// Those that are lent, by their numbers.
static LENT: Mutex<BTreeMap<usize, Arc<Listing>>> = Mutex::new(BTreeMap::new());

static NEXT: AtomicUsize = AtomicUsize::new(1);

/// Additions to lists that are lent no more.
static LATE: Complaints = Complaints::new();

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a library lists during a call.
#[derive(Default)]
pub(crate) struct Listing(Mutex<Listed>);

#[derive(Default)]
pub(crate) struct Listed {
    pub(crate) endpoints: Vec<Endpoint>,
    pub(crate) texts: Vec<(String, String)>,
    pub(crate) refused: Vec<Refused>,
    pub(crate) replies: Vec<(String, Vec<u8>)>,
    entries: usize,
    bytes: usize,
    left_out: u64,
}

impl Listing {
    /// Adds an entry of so many bytes, if there is room for it.
    pub(crate) fn add(&self, bytes: usize, with: impl FnOnce(&mut Listed)) {
        let mut listed = lock(&self.0);
        let room = ROOM - listed.bytes;
        if listed.entries >= ENTRIES || bytes > room {
            listed.left_out += 1;
            return;
        }
        listed.entries += 1;
        listed.bytes += bytes;
        with(&mut listed);
    }

    /// Adds a reply to a request.
    pub(crate) fn reply(&self, from: &str, reply: &[u8]) {
        // Its bytes are copied only where there is room for them.
        let bytes = from.len().saturating_add(reply.len());
        let mut listed = lock(&self.0);
        if listed.replies.len() >= REPLIES || reply.len() > MESSAGE || bytes > ROOM - listed.bytes {
            listed.left_out += 1;
            return;
        }
        listed.bytes += bytes;
        listed.replies.push((from.to_owned(), reply.to_vec()));
    }
}

/// A list that is lent until this is dropped.
pub(crate) struct Lent {
    number: usize,
    list: Arc<Listing>,
}

impl Lent {
    pub(crate) fn new() -> Self {
        let (number, list) = (NEXT.fetch_add(1, Ordering::Relaxed), Arc::<Listing>::default());
        lock(&LENT).insert(number, Arc::clone(&list));
        Self { number, list }
    }

    /// What the library gets.
    pub(crate) fn number(&self) -> Opaque {
        ptr::without_provenance_mut(self.number)
    }

    /// What the library of that name has listed.
    pub(crate) fn into_listed(self, library: &str) -> Listed {
        let listed = std::mem::take(&mut *lock(&self.list.0));
        if listed.left_out > 0 {
            let count = listed.left_out;
            tracing::warn!("{library} lists more than there is room for: {count} were left out");
        }
        listed
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        lock(&LENT).remove(&self.number);
    }
}

/// The list that was lent as this number, if it still is.
pub(crate) fn find(list: Opaque) -> Option<Arc<Listing>> {
    let found = lock(&LENT).get(&list.addr()).cloned();
    if found.is_none()
        && let Some(count) = LATE.add()
    {
        tracing::warn!(
            "a middleware's library adds to a list that is lent no more ({count} times)"
        );
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_is_found_while_it_is_lent() {
        let (one, other) = (Lent::new(), Lent::new());
        let (number, gone) = (one.number(), other.number());
        drop(other);
        let add = |key: &str| {
            find(number).unwrap().add(key.len(), |to| to.texts.push((key.into(), String::new())));
        };
        add("a");
        add("b");
        assert!(find(gone).is_none() && find(ptr::null_mut()).is_none());
        assert_eq!(one.into_listed("mine").texts.len(), 2);
        assert!(find(number).is_none());
    }

    #[test]
    fn what_there_is_no_room_for_is_left_out() {
        let lent = Lent::new();
        let list = find(lent.number()).unwrap();
        let add = |bytes| list.add(bytes, |to| to.texts.push(Default::default()));
        add(ROOM + 1);
        (0..ENTRIES + 7).for_each(|_| add(1));
        let listed = lent.into_listed("mine");
        assert_eq!((listed.texts.len(), listed.left_out), (ENTRIES, 8));
    }

    #[test]
    fn replies_are_limited_in_number_and_size() {
        let lent = Lent::new();
        let list = find(lent.number()).unwrap();
        list.reply("far", &vec![0; MESSAGE + 1]);
        (0..40_u8).for_each(|n| list.reply("near", &[n]));
        let listed = lent.into_listed("mine");
        assert_eq!((listed.replies.len(), listed.left_out), (REPLIES, 25));
        assert_eq!(listed.replies[15], ("near".to_owned(), vec![15]));
    }
}
