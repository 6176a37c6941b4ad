//! The connections of one listener, and the requests of each holder on them.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use axum::body::{Body, Bytes};
use hyper::body::{Body as HttpBody, Frame, SizeHint};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

use crate::rpc::holder::Holder;
use crate::slots::{Full, Slot, Slots};

/// The connections of one listener: so many, further peers wait in the kernel's queue. Who says
/// nothing loses his when a head is due.
#[derive(Debug)]
pub(super) struct Guests {
    seats: Arc<Semaphore>,
    /// For requests under way, of each holder.
    slots: Arc<Slots>,
}

/// A connection; clones are the same one.
#[derive(Clone, Debug)]
pub(super) struct Guest {
    slots: Arc<Slots>,
    _seat: Arc<OwnedSemaphorePermit>,
}

/// A request under way.
#[derive(Debug)]
pub(super) struct Busy {
    _slot: Slot,
}

impl Guests {
    /// Room for so many connections, and for so many requests of one holder at a time.
    pub(super) fn new(most: usize, each: usize) -> Self {
        Self { seats: Arc::new(Semaphore::new(most)), slots: Slots::new(most, each) }
    }

    /// Waits until there is room for one more; none when there never will be.
    pub(super) async fn room(&self) -> Option<Guest> {
        let seat = Arc::clone(&self.seats).acquire_owned().await.ok()?;
        Some(Guest { slots: Arc::clone(&self.slots), _seat: Arc::new(seat) })
    }
}

impl Guest {
    /// A request of somebody who may ask; refused when too many of his are under way.
    pub(super) fn work(&self, holder: &Holder) -> Result<Busy, Full> {
        Ok(Busy { _slot: self.slots.take(holder.share.clone())? })
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

    #[tokio::test]
    async fn the_next_waits_until_a_connection_is_over() {
        let guests = Arc::new(Guests::new(1, 1));
        let somebody = Holder::of("a".to_owned(), Vec::new());
        let guest = guests.room().await.unwrap();
        let busy = guest.work(&somebody).unwrap();
        assert_eq!(guest.work(&somebody).unwrap_err(), Full::All(1));
        let waiting = Arc::clone(&guests);
        let waiting = tokio::spawn(async move { waiting.room().await.is_some() });
        tokio::task::yield_now().await;
        assert!(!waiting.is_finished());
        drop((busy, guest));
        assert!(waiting.await.unwrap());
    }
}
