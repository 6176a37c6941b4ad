//! Ticket of a request: says whether it has begun, and can withdraw it before.

use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

const WAITS: u8 = 0;
const BEGUN: u8 = 1;
const GIVEN_UP: u8 = 2;

/// A request under way. Its sender may give it up until it begins; then it never runs.
#[derive(Clone, Debug, Default)]
pub struct Ticket(Arc<AtomicU8>);

impl Ticket {
    /// Whether its first codel, or the transfer of its data, has begun.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.0.load(Ordering::Acquire) == BEGUN
    }

    /// Marks the request as begun; `false` when it was given up before.
    pub(crate) fn begin(&self) -> bool {
        self.change(BEGUN) != GIVEN_UP
    }

    /// Gives the request up; `false` when it has begun.
    pub(crate) fn give_up(&self) -> bool {
        self.change(GIVEN_UP) != BEGUN
    }

    pub(crate) fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    /// Changes the state if the request still waits; returns the state before.
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
