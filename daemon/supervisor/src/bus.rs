//! What changes in the daemon, numbered, for whoever listens; the last ones are kept.
//!
//! Telling never waits: a listener that does not keep up is told that it lost changes.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use genom_ports::dates::Dates;
pub use genom_protocol::{Change, StepStatus};
use serde::Serialize;
use serde_json::Value;
use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;

/// Something told, and its number.
#[derive(Clone, Debug)]
pub struct Numbered {
    /// From 1, without gaps.
    pub id: u64,
    /// When it was told, as recordings count.
    pub moment: u64,
    /// What was told, as JSON.
    pub data: Arc<Value>,
}

/// How much is kept for listeners that come back (`Last-Event-ID`).
const KEPT: usize = 1024;

/// Where changes are told and heard.
#[derive(Debug)]
pub struct Bus(Numbers);

/// What was told lately, by number, and who listens.
#[derive(Debug)]
pub struct Numbers {
    dates: Dates,
    past: Mutex<Past>,
    live: broadcast::Sender<Numbered>,
}

#[derive(Debug, Default)]
struct Past {
    last: u64,
    kept: VecDeque<Numbered>,
}

impl Bus {
    /// A bus on which nothing was told yet.
    pub fn new(dates: Dates) -> Self {
        Self(Numbers::new(dates))
    }

    /// Tells a change to all listeners.
    pub fn tell(&self, change: &Change) {
        self.0.add(change);
    }

    /// Hears the kept changes after number `after` (none: from now on), and those to come.
    pub fn listen(&self, after: Option<u64>) -> Listener {
        self.0.listen(after)
    }

    /// The changes to come, for who counts itself what it loses.
    pub fn live(&self) -> broadcast::Receiver<Numbered> {
        self.0.live.subscribe()
    }
}

/// What a listener hears next.
#[derive(Clone, Debug)]
pub enum Heard {
    /// Something that was told.
    Told(Numbered),
    /// So much was told that is not kept any more; `last` is the number of the last of it.
    Missed {
        /// How many.
        count: u64,
        /// Number of the last of them.
        last: u64,
    },
}

/// Hears everything in order, or how much it missed.
#[derive(Debug)]
pub struct Listener {
    /// Number of the last that was heard or is known to be missed.
    heard: u64,
    /// Kept ones, before those to come.
    past: VecDeque<Numbered>,
    live: broadcast::Receiver<Numbered>,
}

impl Listener {
    /// All that is kept and was not heard yet, at once; what is not kept is not missed.
    pub fn take_past(&mut self) -> Vec<Numbered> {
        self.heard = self.past.back().map_or(self.heard, |last| last.id);
        std::mem::take(&mut self.past).into()
    }

    /// Waits for the next; `None` when nothing comes any more. It may be given up and called again.
    pub async fn next(&mut self) -> Option<Heard> {
        let next = loop {
            if let Some(kept) = self.past.pop_front() {
                break kept;
            }
            match self.live.recv().await {
                Ok(next) => break next,
                // The number of the next one tells how much.
                Err(RecvError::Lagged(_)) => {}
                Err(RecvError::Closed) => return None,
            }
        };
        let last = next.id.saturating_sub(1);
        let count = last.saturating_sub(self.heard);
        if count > 0 {
            self.heard = last;
            self.past.push_front(next);
            return Some(Heard::Missed { count, last });
        }
        self.heard = next.id;
        Some(Heard::Told(next))
    }
}

impl Numbers {
    /// Nothing told yet.
    pub fn new(dates: Dates) -> Self {
        Self { dates, past: Mutex::default(), live: broadcast::Sender::new(KEPT) }
    }

    /// Numbers it and tells it to all listeners.
    pub fn add(&self, told: &impl Serialize) {
        let data = Arc::new(serde_json::to_value(told).unwrap_or_default());
        let mut past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        past.last += 1;
        let numbered = Numbered { id: past.last, moment: self.dates.moment(), data };
        if past.kept.len() == KEPT {
            past.kept.pop_front();
        }
        past.kept.push_back(numbered.clone());
        // Under the lock, so that numbers are heard in order. Nobody listening is no error.
        let _ = self.live.send(numbered);
    }

    /// Hears what is kept after number `after` (none: from now on), and what is to come.
    pub fn listen(&self, after: Option<u64>) -> Listener {
        let past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        // A number that never was is of a daemon before this one: all of this one is news.
        let heard = after.map_or(past.last, |after| if after > past.last { 0 } else { after });
        let news = past.kept.iter().filter(|change| change.id > heard).cloned();
        Listener { heard, past: news.collect(), live: self.live.subscribe() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(bus: &Bus, count: usize) {
        (0..count).for_each(|_| bus.tell(&Change::Stopping {}));
    }

    /// Numbers of what was told; what was missed as its count and last number.
    async fn heard(listener: &mut Listener) -> Result<u64, (u64, u64)> {
        match listener.next().await.unwrap() {
            Heard::Told(change) => Ok(change.id),
            Heard::Missed { count, last } => Err((count, last)),
        }
    }

    #[tokio::test]
    async fn a_listener_that_comes_back_misses_nothing() {
        let bus = Bus::new(Dates::default());
        told(&bus, 3);
        let mut back = bus.listen(Some(1));
        assert_eq!(heard(&mut back).await, Ok(2));
        assert_eq!(heard(&mut back).await, Ok(3));
        let mut new = bus.listen(None);
        bus.tell(&Change::Disconnected { inport: "a/b".into() });
        assert_eq!(heard(&mut back).await, Ok(4));
        let Some(Heard::Told(next)) = new.next().await else { panic!("nothing was missed") };
        assert_eq!(next.data.to_string(), r#"{"event":"disconnected","in":"a/b"}"#);
        // It heard a daemon that is no more.
        assert_eq!(bus.listen(Some(77)).take_past().len(), 4);
    }

    #[tokio::test]
    async fn a_listener_that_falls_behind_hears_how_much_it_missed() {
        let bus = Bus::new(Dates::default());
        let mut slow = bus.listen(None);
        told(&bus, KEPT);
        assert_eq!(heard(&mut slow).await, Ok(1));
        // One place is free: seven are lost.
        told(&bus, 8);
        assert_eq!(heard(&mut slow).await, Err((7, 8)));
        for id in 9..=KEPT as u64 + 8 {
            assert_eq!(heard(&mut slow).await, Ok(id));
        }
        // It was away, and heard the first two.
        let mut back = bus.listen(Some(2));
        assert_eq!(heard(&mut back).await, Err((6, 8)));
        assert_eq!(heard(&mut back).await, Ok(9));
        // The last missed one's number stands for all of them.
        assert_eq!(heard(&mut bus.listen(Some(8))).await, Ok(9));
    }
}
