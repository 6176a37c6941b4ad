//! Orders: which happening may follow which, as a small automaton.

use crate::happening::Happening;

/// Limit on the steps of an order.
pub const MOST_STEPS: usize = 64;
/// In place of a state: no step leads on.
const NOWHERE: u8 = u8::MAX;

/// What the steps of an automaton name may happen only where one of them allows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Order {
    states: Vec<String>,
    events: Vec<(String, Vec<Happening>)>,
    /// For each state and event, the next state.
    next: Box<[u8]>,
}

/// Why steps are no order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("an order has from 1 to {MOST_STEPS} steps between its states by its events")]
pub struct NoOrder;

impl Order {
    /// An automaton in its first state. Steps are from a state, by an event, to a state.
    ///
    /// # Errors
    /// Too many, or a state or an event that is not there.
    pub fn new(
        states: Vec<String>,
        events: Vec<(String, Vec<Happening>)>,
        steps: &[(usize, usize, usize)],
    ) -> Result<Self, NoOrder> {
        let fits = |&(from, by, to): &(usize, usize, usize)| {
            from < states.len() && by < events.len() && to < states.len()
        };
        if !(1..=MOST_STEPS).contains(&steps.len())
            || states.len() > 2 * MOST_STEPS
            || !steps.iter().all(fits)
        {
            return Err(NoOrder);
        }
        let mut next = vec![NOWHERE; states.len() * events.len()].into_boxed_slice();
        for &(from, by, to) in steps {
            next[from * events.len() + by] = u8::try_from(to).unwrap_or(NOWHERE);
        }
        Ok(Self { states, events, next })
    }

    /// What it hears, each with the number of its event.
    #[must_use]
    pub fn hears(&self) -> Vec<(Happening, usize)> {
        let events = self.events.iter().enumerate();
        events.flat_map(|(at, (_, all))| all.iter().map(move |one| (*one, at))).collect()
    }

    /// The state after this event; `None` if it must not happen.
    #[must_use]
    #[inline]
    pub fn next(&self, state: u8, event: usize) -> Option<u8> {
        let place = usize::from(state) * self.events.len() + event;
        self.next.get(place).copied().filter(|next| *next != NOWHERE)
    }

    /// The name of a state.
    #[must_use]
    pub fn state(&self, state: u8) -> &str {
        self.states.get(usize::from(state)).map_or("", String::as_str)
    }

    /// Names of the events that may happen in a state.
    #[must_use]
    pub fn allowed(&self, state: u8) -> Vec<&str> {
        let all = self.events.iter().enumerate();
        let allowed = all.filter(|(at, _)| self.next(state, *at).is_some());
        allowed.map(|(_, (name, _))| name.as_str()).collect()
    }
}
