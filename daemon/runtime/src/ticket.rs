//! What the sender of a request keeps of it: whether it has begun, and the means to give it up.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const WAITS: u8 = 0;
const BEGUN: u8 = 1;
const GIVEN_UP: u8 = 2;

/// A request on its way. Its sender may give it up until it begins; it never runs then.
#[derive(Clone, Debug, Default)]
pub struct Ticket(Arc<AtomicU8>);

impl Ticket {
    /// Whether its first codel, or the transfer of its data, has begun.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.0.load(Ordering::Acquire) == BEGUN
    }

    /// It begins, and cannot be given up any more; `false` when it was before.
    pub(crate) fn begin(&self) -> bool {
        self.change(BEGUN) != GIVEN_UP
    }

    /// Gives it up; `false` when it has begun.
    pub(crate) fn give_up(&self) -> bool {
        self.change(GIVEN_UP) != BEGUN
    }

    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// What it was.
    fn change(&self, to: u8) -> u8 {
        match self.0.compare_exchange(WAITS, to, Ordering::AcqRel, Ordering::Acquire) {
            Ok(was) | Err(was) => was,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_begins_or_is_given_up_and_never_both() {
        let ticket = Ticket::default();
        assert!(!ticket.has_begun() && ticket.begin() && ticket.has_begun());
        assert!(ticket.begin() && !ticket.give_up());
        let ticket = Ticket::default();
        assert!(ticket.give_up() && ticket.give_up() && !ticket.begin() && !ticket.has_begun());
    }
}
