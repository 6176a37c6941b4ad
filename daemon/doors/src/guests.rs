//! The connections of one listener, and the requests of each holder on them.
//!
//! A listener serves a limited number of connections; further peers wait in the kernel's queue. At
//! an address that anybody can reach, a connection on which no token was shown yet is a stranger's.
//! When all places are taken, the oldest stranger is closed, unless it came less than [`MOMENT`]
//! ago and its request may be on the way. So peers that connect and send nothing, or half a
//! request, hold others up for that moment and not until their time-out.

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

/// A stranger that came less than this ago is not closed.
const MOMENT: Duration = Duration::from_secs(1);

/// Who reaches a listener.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Reach {
    /// The owner of the socket: nobody is a stranger.
    Owner,
    /// Everybody.
    All,
}

/// The connections of one listener.
#[derive(Debug)]
pub(crate) struct Guests {
    most: usize,
    reach: Reach,
    /// For requests under way, of each holder.
    slots: Arc<Slots>,
    state: Mutex<State>,
    /// A connection ended, or came.
    changed: Notify,
}

#[derive(Debug, Default)]
struct State {
    /// How many there are, without those that were asked to go.
    there: usize,
    /// In the order they came.
    strangers: BTreeMap<u64, Stranger>,
    next: u64,
}

#[derive(Debug)]
struct Stranger {
    since: Instant,
    leave: CancellationToken,
}

impl State {
    /// How long until one more has room; none when a connection has to end first.
    fn room_in(&self, most: usize) -> Option<Duration> {
        if self.there < most {
            return Some(Duration::ZERO);
        }
        let (_, oldest) = self.strangers.first_key_value()?;
        Some(MOMENT.saturating_sub(oldest.since.elapsed()))
    }
}

/// A connection; clones are the same one.
#[derive(Clone, Debug)]
pub(crate) struct Guest(Arc<Seat>);

#[derive(Debug)]
struct Seat {
    guests: Arc<Guests>,
    /// Its place among the strangers, as long as it is one.
    number: u64,
    /// Cancelled when it has to go.
    leave: CancellationToken,
}

/// A request under way.
#[derive(Debug)]
pub(crate) struct Busy {
    _slot: Slot,
}

impl Guests {
    /// Room for so many connections, and for so many requests of one holder at a time.
    pub(crate) fn new(most: usize, each: usize, reach: Reach) -> Arc<Self> {
        let slots = Slots::new(most, each);
        let (state, changed) = (Mutex::default(), Notify::new());
        Arc::new(Self { most, reach, slots, state, changed })
    }

    /// Waits until one more can be let in.
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

    /// Lets one in; the oldest stranger goes if there is no room.
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
    /// Cancelled when it has to go.
    pub(crate) fn leave(&self) -> &CancellationToken {
        &self.0.leave
    }

    /// A request of a holder of rights, whose connection is no stranger's from now on; refused when
    /// too many requests of that holder are under way.
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
        // One that was asked to go was taken off the count then.
        if !self.leave.is_cancelled() {
            state.there -= 1;
        }
        self.guests.changed.notify_waiters();
    }
}

/// A body, and what is kept as long as it is sent.
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
