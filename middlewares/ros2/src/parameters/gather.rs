//! Combines the replies to several requests into one.

use std::sync::{Arc, Mutex};

use genom_middleware::{ActivityId, Outcome, Replies};

use crate::lock::lock;

type Then<T> = Box<dyn FnOnce(Vec<T>) + Send>;

/// Results of several requests. When all have arrived or were given up, `then` is called.
pub(super) struct Gather<T> {
    results: Mutex<Vec<T>>,
    then: Mutex<Option<Then<T>>>,
}

impl<T: Send + 'static> Gather<T> {
    /// `given_up` has the results to use where none arrives.
    pub(super) fn new(given_up: Vec<T>, then: impl FnOnce(Vec<T>) + Send + 'static) -> Arc<Self> {
        let then: Then<T> = Box::new(then);
        Arc::new(Self { results: Mutex::new(given_up), then: Mutex::new(Some(then)) })
    }

    pub(super) fn put(&self, place: usize, result: T) {
        if let Some(to) = lock(&self.results).get_mut(place) {
            *to = result;
        }
    }

    /// Receives the replies to one of the requests.
    pub(super) fn place(
        self: &Arc<Self>,
        place: usize,
        result: impl FnOnce(Outcome) -> T + Send + 'static,
    ) -> Box<dyn Replies> {
        Box::new(Place { gather: Arc::clone(self), place, result })
    }
}

// Dropped after the last result has arrived.
impl<T> Drop for Gather<T> {
    fn drop(&mut self) {
        let results = std::mem::take(&mut *lock(&self.results));
        if let Some(then) = lock(&self.then).take() {
            then(results);
        }
    }
}

struct Place<T, F> {
    gather: Arc<Gather<T>>,
    place: usize,
    result: F,
}

impl<T, F> Replies for Place<T, F>
where
    T: Send + 'static,
    F: FnOnce(Outcome) -> T + Send,
{
    fn accepted(&mut self, _: ActivityId) {}

    fn feedback(&mut self, _: &str) {}

    fn finish(self: Box<Self>, outcome: Outcome) {
        let Self { gather, place, result } = *self;
        gather.put(place, result(outcome));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_handed_on_when_the_last_one_is_there_or_given_up() {
        let (told, heard) = std::sync::mpsc::channel();
        let gather = Gather::new(vec![0; 3], move |all| told.send(all).unwrap());
        let first = gather.place(0, |_| 1);
        let second = gather.place(1, |_| 2);
        gather.put(2, 3);
        drop(gather);
        first.finish(Outcome::Lost(genom_middleware::CallError::Gone));
        assert!(heard.try_recv().is_err());
        drop(second);
        assert_eq!(heard.try_recv().unwrap(), [1, 0, 3]);
    }
}
