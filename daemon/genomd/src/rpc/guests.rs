//! The connections of one listener: so many, and never a closed door.
//!
//! A connection is busy while a request of somebody who may ask is under way; all others only
//! wait to be used, or were never meant to be. When there is no room for one more, the oldest of
//! those goes, strangers first, unless it came a moment ago: its request may be on the way. Whoever
//! opens connections and says nothing, or half of something, holds others up for that moment only.

use std::collections::BTreeMap;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::time::{Duration, Instant};

use axum::body::{Body, Bytes};
use hyper::body::{Body as HttpBody, Frame, SizeHint};
use tokio::sync::Notify;

use crate::flag::Flag;
use crate::rpc::holder::Holder;
use crate::slots::{Full, Slot, Slots};

/// So long nobody is asked to go who may be about to say something.
const MOMENT: Duration = Duration::from_secs(1);

/// The connections of one listener.
#[derive(Debug)]
pub(super) struct Guests {
    most: usize,
    /// For requests under way, of each holder.
    slots: Arc<Slots>,
    state: Mutex<State>,
    /// One left, or one is idle.
    room: Notify,
}

#[derive(Debug, Default)]
struct State {
    /// How many there are.
    there: usize,
    /// Those that may be asked to go: strangers first, then the one that is idle longest.
    idle: BTreeMap<(bool, u64), Idle>,
    next: u64,
}

/// A connection that says nothing.
#[derive(Debug)]
struct Idle {
    since: Instant,
    leave: Flag,
}

impl Idle {
    fn new(leave: &Flag) -> Self {
        Self { since: Instant::now(), leave: leave.clone() }
    }
}

impl State {
    /// How long until one more has room; none when somebody has to end something first.
    fn room_in(&self, most: usize) -> Option<Duration> {
        if self.there < most {
            return Some(Duration::ZERO);
        }
        let (_, oldest) = self.idle.first_key_value()?;
        Some(MOMENT.saturating_sub(oldest.since.elapsed()))
    }
}

/// A connection; clones are the same one.
#[derive(Clone, Debug)]
pub(super) struct Guest(Arc<Seat>);

#[derive(Debug)]
struct Seat {
    guests: Arc<Guests>,
    /// Raised when it has to go.
    leave: Flag,
    own: Mutex<Own>,
}

#[derive(Debug)]
struct Own {
    /// Requests under way.
    busy: usize,
    /// Whether somebody who may ask ever did.
    known: bool,
    /// Its place among the idle ones.
    place: Option<(bool, u64)>,
}

/// A request under way.
#[derive(Debug)]
pub(super) struct Busy {
    guest: Guest,
    _slot: Slot,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Guests {
    /// Room for so many connections, and for so many requests of one holder at a time.
    pub(super) fn new(most: usize, each: usize) -> Arc<Self> {
        let slots = Slots::new(most, each);
        Arc::new(Self { most, slots, state: Mutex::default(), room: Notify::new() })
    }

    /// Waits until one more can be let in.
    pub(super) async fn room(&self) {
        loop {
            let changed = self.room.notified();
            let wait = lock(&self.state).room_in(self.most);
            match wait {
                Some(Duration::ZERO) => return,
                Some(wait) => {
                    let _ = tokio::time::timeout(wait, changed).await;
                }
                None => changed.await,
            }
        }
    }

    /// Lets one in; the oldest idle one goes if there is no room.
    pub(super) fn enter(self: &Arc<Self>) -> Guest {
        let leave = Flag::new();
        let mut state = lock(&self.state);
        if state.there >= self.most
            && let Some((_, oldest)) = state.idle.pop_first()
        {
            oldest.leave.raise();
            state.there -= 1;
        }
        state.there += 1;
        drop(state);
        let own = Mutex::new(Own { busy: 0, known: false, place: None });
        Guest(Arc::new(Seat { guests: Arc::clone(self), leave, own }))
    }
}

impl Guest {
    /// What it says is read from now on: who says nothing may be asked to go.
    pub(super) fn is_heard(&self) {
        lock(&self.0.own).rests(&self.0);
    }

    /// Raised when it has to go.
    pub(super) fn leave(&self) -> &Flag {
        &self.0.leave
    }

    /// A request of somebody who may ask; refused when too many of his are under way.
    pub(super) fn work(&self, holder: &Holder) -> Result<Busy, Full> {
        let slot = self.0.guests.slots.take(holder.share.clone())?;
        let mut own = lock(&self.0.own);
        own.busy += 1;
        own.known = true;
        if let Some(place) = own.place.take() {
            lock(&self.0.guests.state).idle.remove(&place);
        }
        drop(own);
        Ok(Busy { guest: self.clone(), _slot: slot })
    }
}

impl Own {
    /// No request is under way.
    fn rests(&mut self, seat: &Seat) {
        let mut state = lock(&seat.guests.state);
        let place = (self.known, state.next);
        state.next += 1;
        state.idle.insert(place, Idle::new(&seat.leave));
        self.place = Some(place);
        seat.guests.room.notify_waiters();
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        let seat = &self.guest.0;
        let mut own = lock(&seat.own);
        own.busy -= 1;
        if own.busy == 0 && !seat.leave.is_up() {
            own.rests(seat);
        }
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        let own = lock(&self.own);
        let mut state = lock(&self.guests.state);
        if let Some(place) = own.place {
            state.idle.remove(&place);
        }
        // Who was asked to go does not count any more.
        if !self.leave.is_up() {
            state.there -= 1;
        }
        self.guests.room.notify_waiters();
    }
}

/// A body, and what is kept as long as it is sent.
pub(super) struct Held {
    body: Body,
    _busy: Option<Busy>,
}

impl Held {
    pub(super) fn new(body: Body, busy: Option<Busy>) -> Self {
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

    fn somebody(name: &str) -> Holder {
        Holder::of(name.to_owned(), Vec::new())
    }

    #[tokio::test]
    async fn whoever_says_nothing_makes_room_and_strangers_first() {
        let guests = Guests::new(3, 3);
        let known = guests.enter();
        drop(known.work(&somebody("a")).unwrap());
        let (first, second) = (guests.enter(), guests.enter());
        first.is_heard();
        second.is_heard();
        assert!(lock(&guests.state).room_in(3).is_some_and(|wait| !wait.is_zero()), "too young");
        guests.room().await;
        let third = guests.enter();
        third.is_heard();
        assert!(first.leave().is_up() && !second.leave().is_up() && !known.leave().is_up());
        drop(first);
        let _working = [second.work(&somebody("a")).unwrap(), third.work(&somebody("a")).unwrap()];
        let _fourth = guests.enter();
        assert!(known.leave().is_up(), "the only idle one");
        assert_eq!(lock(&guests.state).there, 3);
    }

    #[tokio::test]
    async fn busy_ones_stay_and_the_next_waits() {
        let guests = Guests::new(1, 1);
        let guest = guests.enter();
        let busy = guest.work(&somebody("a")).unwrap();
        assert_eq!(guest.work(&somebody("a")).unwrap_err(), Full::All(1));
        let waiting = Arc::clone(&guests);
        let waiting = tokio::spawn(async move { waiting.room().await });
        tokio::task::yield_now().await;
        assert!(!waiting.is_finished());
        drop(busy);
        waiting.await.unwrap();
        assert!(!guest.leave().is_up(), "it goes when somebody comes");
    }
}
