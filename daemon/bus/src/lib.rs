//! The daemon's changes, as numbered messages to any number of listeners. The latest are kept, so
//! that a listener can reconnect.
//!
//! Sending never blocks: a listener that is too slow is told how many messages it missed.

#![forbid(unsafe_code)]

pub mod chronicle;
pub mod flag;
mod numbered;
pub mod startup;
pub mod withheld;

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use genom_ports::dates::Dates;
pub use genom_protocol::{Change, StepStatus};
use serde::Serialize;
use serde_json::Value;
use tokio::sync::broadcast;
use tokio::sync::broadcast::error::RecvError;

use crate::chronicle::{Chronicle, Excerpt};
pub use crate::numbered::{Numbered, Teller};

/// Number of messages kept for listeners that reconnect (`Last-Event-ID`).
const KEPT: usize = 1024;

/// Sends changes to listeners.
///
/// ```
/// use genom_ports::dates::Dates;
/// use genom_bus::{Bus, Change};
///
/// let bus = Bus::new(Dates::default());
/// bus.tell(&Change::ComponentUnloaded { component: "demo".into() });
///
/// // A listener that comes back after message 0 receives what is kept.
/// let kept = bus.listen(Some(0)).take_past();
/// assert_eq!((kept[0].id, &kept[0].data["component"]), (1, &"demo".into()));
/// ```
#[derive(Debug)]
pub struct Bus {
    numbers: Numbers,
    also: OnceLock<Also>,
}

/// Hears what this process tells, at once.
struct Also(Box<dyn Fn(&Numbered) + Send + Sync>);

impl std::fmt::Debug for Also {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Also")
    }
}

/// Numbers messages, keeps the latest, and sends them to listeners.
#[derive(Debug)]
pub struct Numbers {
    dates: Dates,
    past: Mutex<Past>,
    live: broadcast::Sender<Numbered>,
    chronicle: Chronicle,
}

#[derive(Debug, Default)]
struct Past {
    last: u64,
    kept: VecDeque<Numbered>,
}

impl Bus {
    /// A bus without messages.
    pub fn new(dates: Dates) -> Self {
        Self { numbers: Numbers::new(dates), also: OnceLock::new() }
    }

    /// Sends a change to all listeners.
    pub fn tell(&self, change: &Change) {
        let told = self.numbers.send(change, None);
        if let Some(Also(hear)) = self.also.get() {
            hear(&told);
        }
    }

    /// Tells on a change of another process of this daemon, with who told it if it was told there.
    pub fn tell_on(&self, change: &Value, teller: Option<Teller>) {
        self.numbers.send(change, teller);
    }

    /// Has `hear` called with each change of this process, by the thread that tells it: what it
    /// does is done, even if the process is killed next. Only the first one is.
    pub fn also(&self, hear: impl Fn(&Numbered) + Send + Sync + 'static) {
        let _ = self.also.set(Also(Box::new(hear)));
    }

    /// A listener that starts after message number `after`; with `None`, after the latest one.
    pub fn listen(&self, after: Option<u64>) -> Listener {
        self.numbers.listen(after)
    }

    /// Keeps the changes of the last minutes from now on, besides the latest, which are kept anyway.
    pub fn keep(&self) {
        let moment = self.numbers.dates.moment();
        // With the messages locked, so that none is added meanwhile.
        let past = self.numbers.past.lock().unwrap_or_else(PoisonError::into_inner);
        self.numbers.chronicle.begin(moment, || past.kept.clone());
    }

    /// At most `most` of the changes that are kept, those after number `after`; none before
    /// [`keep`](Self::keep) was called.
    pub fn excerpt(&self, after: u64, most: usize) -> Excerpt {
        self.numbers.chronicle.after(after, most)
    }

    /// The changes from now on, for receivers that count their losses themselves.
    pub fn live(&self) -> broadcast::Receiver<Numbered> {
        self.live_after().0
    }

    /// The same, with the number of the last change before them.
    pub fn live_after(&self) -> (broadcast::Receiver<Numbered>, u64) {
        let past = self.numbers.past.lock().unwrap_or_else(PoisonError::into_inner);
        (self.numbers.live.subscribe(), past.last)
    }
}

/// What a listener receives.
#[derive(Clone, Debug)]
pub enum Heard {
    /// The next message.
    Told(Numbered),
    /// Messages that were lost because they are not kept any more.
    Missed {
        /// How many were lost.
        count: u64,
        /// Number of the last one lost.
        last: u64,
    },
}

/// Receives all messages in order, and learns how many it missed.
#[derive(Debug)]
pub struct Listener {
    /// Number of the last message received or reported as missed.
    heard: u64,
    /// Kept messages that come before those of `live`.
    past: VecDeque<Numbered>,
    live: broadcast::Receiver<Numbered>,
}

impl Listener {
    /// All kept messages that this listener has not received yet. Older ones are not reported as
    /// missed.
    pub fn take_past(&mut self) -> Vec<Numbered> {
        self.heard = self.past.back().map_or(self.heard, |last| last.id);
        std::mem::take(&mut self.past).into()
    }

    /// Waits for the next message; `None` once the bus is gone. Cancel safe.
    pub async fn next(&mut self) -> Option<Heard> {
        let next = loop {
            if let Some(kept) = self.past.pop_front() {
                break kept;
            }
            match self.live.recv().await {
                Ok(next) => break next,
                // The number of the next message tells how many were lost.
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
    /// No messages yet.
    pub fn new(dates: Dates) -> Self {
        let live = broadcast::Sender::new(KEPT);
        Self { dates, past: Mutex::default(), live, chronicle: Chronicle::default() }
    }

    /// Gives the message a number and sends it to all listeners.
    pub fn add(&self, told: &impl Serialize) {
        self.send(told, None);
    }

    fn send(&self, told: &impl Serialize, teller: Option<Teller>) -> Numbered {
        let data = Arc::new(serde_json::to_value(told).unwrap_or_default());
        let mut past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        past.last += 1;
        let numbered = Numbered { id: past.last, moment: self.dates.moment(), data, teller };
        if past.kept.len() == KEPT {
            past.kept.pop_front();
        }
        past.kept.push_back(numbered.clone());
        self.chronicle.add(&numbered);
        // Sent under the lock, so that listeners receive messages in order of their numbers. Having
        // no listener is not an error.
        let _ = self.live.send(numbered.clone());
        numbered
    }

    /// A listener that starts after message number `after`; with `None`, after the latest one.
    pub fn listen(&self, after: Option<u64>) -> Listener {
        let past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        // A number greater than the latest comes from an earlier run of the daemon: the listener
        // knows none of the messages of this one.
        let heard = after.map_or(past.last, |after| if after > past.last { 0 } else { after });
        let news = past.kept.iter().filter(|change| change.id > heard).cloned();
        Listener { heard, past: news.collect(), live: self.live.subscribe() }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use genom_runtime::{Clock, VirtualClock};

    use super::*;

    fn told(bus: &Bus, count: usize) {
        (0..count).for_each(|_| bus.tell(&Change::Stopping {}));
    }

    /// The number of the next message, or count and last number of those missed.
    async fn heard(listener: &mut Listener) -> Result<u64, (u64, u64)> {
        match listener.next().await.unwrap() {
            Heard::Told(change) => Ok(change.id),
            Heard::Missed { count, last } => Err((count, last)),
        }
    }

    #[test]
    fn a_chronicle_keeps_changes_from_the_first_request_for_a_bounded_time_and_number() {
        let time = Arc::new(VirtualClock::new());
        let bus = Bus::new(Dates::of(&Clock::Virtual(Arc::clone(&time))));
        told(&bus, 2);
        assert!(bus.excerpt(0, 10).changes.is_empty());
        bus.keep();
        let ids = |after, most| {
            let Excerpt { changes, missed, left, .. } = bus.excerpt(after, most);
            (changes.iter().map(|one| one.id).collect::<Vec<_>>(), missed, left)
        };
        assert_eq!(ids(0, 10), (vec![1, 2], 0, 0));
        time.step(chronicle::KEPT_FOR / 2);
        told(&bus, 1);
        assert_eq!(ids(1, 1), (vec![2], 0, 1));
        // What is too old has not been missed.
        time.step(chronicle::KEPT_FOR / 2 + Duration::from_secs(1));
        told(&bus, 1);
        assert_eq!(ids(0, 10), (vec![3, 4], 0, 0));
        assert_eq!(bus.excerpt(0, 10).since, 1_000_000_000);
        // What there is no room for has.
        told(&bus, chronicle::MOST);
        let (kept, missed, left) = ids(3, usize::MAX);
        assert_eq!((kept.len(), kept[0], missed, left), (chronicle::MOST, 5, 1, 0));
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
        // The number is from an earlier run of the daemon.
        assert_eq!(bus.listen(Some(77)).take_past().len(), 4);
    }

    #[tokio::test]
    async fn a_listener_that_falls_behind_hears_how_much_it_missed() {
        let bus = Bus::new(Dates::default());
        let mut slow = bus.listen(None);
        told(&bus, KEPT);
        assert_eq!(heard(&mut slow).await, Ok(1));
        // One place is free: seven messages are lost.
        told(&bus, 8);
        assert_eq!(heard(&mut slow).await, Err((7, 8)));
        for id in 9..=KEPT as u64 + 8 {
            assert_eq!(heard(&mut slow).await, Ok(id));
        }
        // It received the first two before it disconnected.
        let mut back = bus.listen(Some(2));
        assert_eq!(heard(&mut back).await, Err((6, 8)));
        assert_eq!(heard(&mut back).await, Ok(9));
        // Messages up to the last one missed are not counted again.
        assert_eq!(heard(&mut bus.listen(Some(8))).await, Ok(9));
    }
}
