//! Limits the connections of one listener, and the requests of each client on them.
//!
//! A listener serves a limited number of connections; further peers wait in the kernel's queue. At
//! an address that anybody can reach, a connection counts as a stranger's until a request with a
//! token arrives on it. When the limit is reached, the connection of the oldest stranger is closed,
//! unless it is younger than [`MOMENT`], so that its request may still arrive. Peers that connect
//! and send nothing, or an incomplete request, therefore delay others by that time only, not until
//! their timeout.

use std::collections::BTreeMap;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use axum::body::{Body, Bytes};
use hyper::body::{Body as HttpBody, Frame, SizeHint};
use tokio::sync::Notify;
use tokio_util::sync::CancellationToken;

use crate::holder::Holder;
use crate::slots::{Full, Slot, Slots};

/// A stranger's connection is not closed before this time.
const MOMENT: Duration = Duration::from_secs(1);

/// Who can connect to a listener.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reach {
    /// Only the owner of the socket: there are no strangers.
    Owner,
    /// Everybody.
    All,
}

/// The connections of one listener.
#[derive(Debug)]
pub(crate) struct Guests {
    most: usize,
    reach: Reach,
    /// Slots for requests under way, by client.
    slots: Arc<Slots>,
    state: Mutex<State>,
    /// Notified when a connection begins or ends.
    changed: Notify,
}

#[derive(Debug, Default)]
struct State {
    /// Number of connections, without those that were asked to close.
    there: usize,
    /// In order of their arrival.
    strangers: BTreeMap<u64, Stranger>,
    next: u64,
}

#[derive(Debug)]
struct Stranger {
    since: Instant,
    leave: CancellationToken,
}

impl State {
    /// Time until a stranger may be closed in favour of another connection; `None` if a connection
    /// has to end first.
    fn room_in(&self, most: usize) -> Option<Duration> {
        if self.there < most {
            return Some(Duration::ZERO);
        }
        let (_, oldest) = self.strangers.first_key_value()?;
        Some(MOMENT.saturating_sub(oldest.since.elapsed()))
    }
}

/// A connection; clones refer to the same one.
#[derive(Clone, Debug)]
pub(crate) struct Guest(Arc<Seat>);

#[derive(Debug)]
struct Seat {
    guests: Arc<Guests>,
    /// Its key among the strangers, as long as it is one.
    number: u64,
    /// Cancelled to close the connection.
    leave: CancellationToken,
}

/// A request under way; frees its slot when dropped.
#[derive(Debug)]
pub(crate) struct Busy {
    _slot: Slot,
}

impl Guests {
    /// Allows `most` connections, and `each` requests at once per client.
    pub(crate) fn new(most: usize, each: usize, reach: Reach) -> Arc<Self> {
        let slots = Slots::new(most, each);
        let (state, changed) = (Mutex::default(), Notify::new());
        Arc::new(Self { most, reach, slots, state, changed })
    }

    /// Waits until another connection can be accepted.
    pub(crate) async fn room(&self) {
        loop {
            let changed = self.changed.notified();
            let wait = self.lock().room_in(self.most);
            match wait {
                Some(Duration::ZERO) => return,
                Some(wait) => {
                    let _ = tokio::time::timeout(wait, changed).await;
                }
                None => changed.await,
            }
        }
    }

    /// Adds a connection; if there is no room, asks the oldest stranger's to close.
    pub(crate) fn enter(self: &Arc<Self>) -> Guest {
        let leave = CancellationToken::new();
        let mut state = self.lock();
        if state.there >= self.most
            && let Some((_, oldest)) = state.strangers.pop_first()
        {
            oldest.leave.cancel();
            state.there -= 1;
        }
        state.there += 1;
        let number = state.next;
        state.next += 1;
        if self.reach == Reach::All {
            let since = Instant::now();
            state.strangers.insert(number, Stranger { since, leave: leave.clone() });
        }
        drop(state);
        Guest(Arc::new(Seat { guests: Arc::clone(self), number, leave }))
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Guest {
    /// Cancelled to close the connection.
    pub(crate) fn leave(&self) -> &CancellationToken {
        &self.0.leave
    }

    /// Begins a request of an authenticated client; from now on the connection is not a stranger's.
    /// Fails if too many requests of that client are under way.
    pub(crate) fn work(&self, holder: &Holder) -> Result<Busy, Full> {
        let seat = &self.0;
        seat.guests.lock().strangers.remove(&seat.number);
        Ok(Busy { _slot: seat.guests.slots.take(holder.share.clone())? })
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let mut state = self.guests.lock();
        state.strangers.remove(&self.number);
        // A connection that was asked to close is not counted any more.
        if !self.leave.is_cancelled() {
            state.there -= 1;
        }
        self.guests.changed.notify_waiters();
    }
}

/// A body with a value that is kept until the body was sent.
pub(crate) struct Held {
    body: Body,
    _busy: Option<Busy>,
}

impl Held {
    pub(crate) fn new(body: Body, busy: Option<Busy>) -> Self {
        Self { body, _busy: busy }
    }
}

impl HttpBody for Held {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn somebody() -> Holder {
        Holder::of("a".to_owned(), Vec::new())
    }

    #[tokio::test]
    async fn the_oldest_stranger_makes_room_and_nobody_who_showed_a_token() {
        let guests = Guests::new(3, 3, Reach::All);
        let known = guests.enter();
        drop(known.work(&somebody()).unwrap());
        let (first, second) = (guests.enter(), guests.enter());
        assert!(guests.lock().room_in(3).is_some_and(|wait| !wait.is_zero()), "too young");
        guests.room().await;
        let _third = guests.enter();
        assert!(first.leave().is_cancelled());
        assert!(!second.leave().is_cancelled() && !known.leave().is_cancelled());
        drop(first);
        assert_eq!(guests.lock().there, 3);
    }

    #[tokio::test]
    async fn where_nobody_is_a_stranger_the_next_waits_until_a_connection_is_over() {
        for reach in [Reach::Owner, Reach::All] {
            let guests = Guests::new(1, 1, reach);
            let guest = guests.enter();
            let busy = guest.work(&somebody()).unwrap();
            assert_eq!(guest.work(&somebody()).unwrap_err(), Full::All(1));
            assert_eq!(guests.lock().room_in(1), None);
            let waiting = Arc::clone(&guests);
            let waiting = tokio::spawn(async move { waiting.room().await });
            tokio::task::yield_now().await;
            assert!(!waiting.is_finished());
            drop((busy, guest));
            waiting.await.unwrap();
        }
    }
}
