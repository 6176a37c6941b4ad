//! Orders that threads move on: where each is takes one byte.

use std::sync::atomic::{AtomicU8, Ordering};

use crate::order::Order;

/// An order at one moment. Threads that meet at it wait for nobody, and each step counts.
#[derive(Debug)]
pub struct Sequence {
    order: Order,
    state: AtomicU8,
    /// All that it hears of happens in one thread.
    sole: bool,
}

impl Sequence {
    /// In its first state; whether all that it hears of happens in one thread.
    #[must_use]
    pub fn new(order: Order, sole: bool) -> Self {
        Self { order, state: AtomicU8::new(0), sole }
    }

    /// This event of it happens.
    ///
    /// # Errors
    /// The state in which it must not.
    #[inline]
    pub fn hear(&self, event: usize) -> Result<(), u8> {
        let mut state = self.state.load(Ordering::Acquire);
        loop {
            let next = self.order.next(state, event).ok_or(state)?;
            if next == state {
                return Ok(());
            }
            if self.sole {
                self.state.store(next, Ordering::Release);
                return Ok(());
            }
            let moved =
                self.state.compare_exchange_weak(state, next, Ordering::AcqRel, Ordering::Acquire);
            match moved {
                Ok(_) => return Ok(()),
                Err(other) => state = other,
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use std::sync::Barrier;

    use super::*;

    /// States one after the other in a circle, and one more event that none allows.
    fn circle(states: usize, sole: bool) -> Sequence {
        let names = (0..states).map(|at| at.to_string()).collect();
        let events = vec![("go".to_owned(), Vec::new()), ("not".to_owned(), Vec::new())];
        let steps: Vec<_> = (0..states).map(|at| (at, 0, (at + 1) % states)).collect();
        Sequence::new(Order::new(names, events, &steps).unwrap(), sole)
    }

    #[test]
    fn an_order_goes_on_by_what_is_allowed_and_stays_where_it_is_by_what_is_not() {
        for sole in [false, true] {
            let order = circle(3, sole);
            assert_eq!((order.hear(0), order.hear(0)), (Ok(()), Ok(())));
            assert_eq!((order.hear(1), order.hear(0)), (Err(2), Ok(())));
            assert_eq!(order.hear(1), Err(0));
        }
    }

    #[test]
    fn each_step_counts_of_threads_that_meet_at_an_order() {
        const STEPS: usize = 20_000;
        let (order, begin) = (circle(61, false), Barrier::new(3));
        std::thread::scope(|scope| {
            for _ in 0..3 {
                scope.spawn(|| {
                    begin.wait();
                    (0..STEPS).for_each(|_| order.hear(0).unwrap());
                });
            }
        });
        let state = order.state.load(Ordering::Relaxed);
        assert_eq!(usize::from(state), 3 * STEPS % 61);
    }
}
