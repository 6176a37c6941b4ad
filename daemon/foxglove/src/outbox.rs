//! What waits to be sent to one client: never more than it may, however slowly the client reads.

use std::collections::VecDeque;
use std::sync::Mutex;

use tokio::sync::Notify;
use tokio_tungstenite::tungstenite::Message;

use crate::lock::lock;

/// Bytes of replies and announcements that may wait. These are never left out: a client that lets so
/// many wait is sent away.
const MOST_WORDS: usize = 32 << 20;

/// Messages to one client, in two queues.
#[derive(Debug)]
pub(crate) struct Outbox {
    /// Bytes of samples that may wait.
    most: usize,
    state: Mutex<State>,
    more: Notify,
}

#[derive(Debug, Default)]
struct State {
    /// Replies and announcements.
    words: Queue,
    samples: Queue,
    /// Samples that were left out, and how many the client was told of.
    dropped: u64,
    told: u64,
    /// Whether the client is to be sent away.
    over: bool,
}

#[derive(Debug, Default)]
struct Queue {
    all: VecDeque<Message>,
    bytes: usize,
}

impl Queue {
    fn push(&mut self, message: Message) {
        self.bytes += message.len();
        self.all.push_back(message);
    }

    fn pop(&mut self) -> Option<Message> {
        let first = self.all.pop_front()?;
        self.bytes -= first.len();
        Some(first)
    }
}

impl Outbox {
    /// Of `most` bytes of samples.
    pub(crate) fn new(most: usize) -> Self {
        Self { most, state: Mutex::default(), more: Notify::new() }
    }

    /// Adds a reply or an announcement.
    pub(crate) fn say(&self, message: Message) {
        let mut state = lock(&self.state);
        state.words.push(message);
        state.over |= state.words.bytes > MOST_WORDS;
        drop(state);
        self.more.notify_one();
    }

    /// Adds a sample. The oldest ones make room for it.
    pub(crate) fn sample(&self, message: Message) {
        let mut state = lock(&self.state);
        state.samples.push(message);
        while state.samples.bytes > self.most && state.samples.pop().is_some() {
            state.dropped += 1;
        }
        drop(state);
        self.more.notify_one();
    }

    /// The next message; announcements come before samples. `None` if the client is to be sent away.
    pub(crate) async fn next(&self) -> Option<Message> {
        loop {
            let more = self.more.notified();
            {
                let mut state = lock(&self.state);
                if state.over {
                    return None;
                }
                if let Some(message) = state.words.pop().or_else(|| state.samples.pop()) {
                    return Some(message);
                }
            }
            more.await;
        }
    }

    /// How many samples were left out so far, if that changed since it was asked last.
    pub(crate) fn newly_dropped(&self) -> Option<u64> {
        let mut state = lock(&self.state);
        let changed = state.dropped != state.told;
        state.told = state.dropped;
        changed.then_some(state.dropped)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(byte: u8, size: usize) -> Message {
        Message::Binary(vec![byte; size].into())
    }

    #[tokio::test]
    async fn the_oldest_samples_make_room_and_are_counted() {
        let outbox = Outbox::new(100);
        for byte in 0..5 {
            outbox.sample(of(byte, 40));
        }
        outbox.say(Message::text("words come first"));
        assert_eq!(outbox.next().await, Some(Message::text("words come first")));
        assert_eq!(outbox.next().await, Some(of(3, 40)));
        assert_eq!(outbox.next().await, Some(of(4, 40)));
        assert_eq!((outbox.newly_dropped(), outbox.newly_dropped()), (Some(3), None));
        outbox.sample(of(9, 101));
        assert_eq!(outbox.newly_dropped(), Some(4), "it would never fit");
    }

    #[tokio::test]
    async fn a_client_that_lets_announcements_pile_up_is_sent_away() {
        let outbox = Outbox::new(100);
        for _ in 0..33 {
            outbox.say(of(0, 1 << 20));
        }
        assert_eq!(outbox.next().await, None);
    }
}
