//! Keeps RustDDS from announcing large samples that it has not sent yet.
//!
//! The periodic heartbeat of RustDDS 0.15.1 names all samples that were written, also one that it
//! is only about to send (`rtps/writer.rs`, `handle_heartbeat_tick`). The reader asks for what it
//! has not got, and a large sample goes out twice at once: more than the buffer of its socket has
//! room for. So such a heartbeat is narrowed to what was sent; the sample itself is followed by one
//! that names it.

use std::collections::HashMap;
use std::time::Duration;

use super::super::limits::FLOWS;
use super::super::message::{Entity, Fields, HEADER, Head, is_builtin, kind, put_number};
use super::super::tally::Reason;
use super::cut::Cut;

/// How long a sample may remain unannounced: RustDDS sends it at once, unless nobody reads.
const LONGEST: Duration = Duration::from_millis(100);

/// What a writer of ours has sent, of those whose last sample was in fragments.
#[derive(Clone, Copy, Debug)]
struct Writer {
    /// Greatest number of which all was sent.
    sent: i64,
    /// A greater number that was to be announced, and since when.
    waits: Option<(i64, Duration)>,
}

#[derive(Debug, Default)]
pub(crate) struct Announced(HashMap<Entity, Writer>);

impl Announced {
    /// What to send instead of a message of ours; `None` if it may go as it is. The time is looked
    /// at only for a heartbeat that may have to wait.
    pub(crate) fn narrowed(
        &mut self,
        message: &[u8],
        now: impl Fn() -> Duration,
    ) -> Option<Vec<u8>> {
        // An empty map has nothing to narrow, and most messages have no heartbeat.
        if self.0.is_empty() {
            return None;
        }
        let mut left = None;
        let mut at = HEADER;
        while let Ok(Some(head)) = Head::read(message, at) {
            at = head.body.end;
            if head.kind == kind::HEARTBEAT
                && let Some(body) = message.get(head.body.clone())
                && let Ok((writer, first, last)) = heartbeat(body, head.little())
                && let Some(narrowed) = self.heartbeat(writer, first, last, &now)
            {
                let left = left.get_or_insert_with(|| message.to_vec());
                if let Some(body) = left.get_mut(head.body) {
                    put_number(body, 16, head.flags & 1 == 1, narrowed);
                }
            }
        }
        left
    }

    /// The last number to announce instead; `None` if it may be announced.
    fn heartbeat(
        &mut self,
        writer: Entity,
        first: i64,
        last: i64,
        now: impl Fn() -> Duration,
    ) -> Option<i64> {
        let Writer { sent, waits } = self.0.get_mut(&writer)?;
        if last <= *sent {
            return None;
        }
        let now = now();
        let since = match *waits {
            Some((number, since)) if number > *sent => since,
            _ => now,
        };
        *waits = Some((last, since));
        // With nothing to announce, the last is the one before the first (8.3.8.6.3).
        (now.saturating_sub(since) < LONGEST).then(|| (*sent).max(first.saturating_sub(1)))
    }

    /// A message of ours was sent.
    pub(crate) fn sent(&mut self, message: &[u8]) {
        let mut at = HEADER;
        while let Ok(Some(head)) = Head::read(message, at) {
            at = head.body.end;
            if let Some((writer, number, last)) = sample(message, &head)
                && !is_builtin(writer)
                && (head.kind == kind::DATA_FRAG || self.0.contains_key(&writer))
                && (self.0.len() < FLOWS || self.0.contains_key(&writer))
            {
                let unsent = Writer { sent: number.saturating_sub(1), waits: None };
                let of = self.0.entry(writer).or_insert(unsent);
                if last {
                    of.sent = of.sent.max(number);
                }
            }
        }
    }
}

/// The writer of a heartbeat, and the first and last number that it names (8.3.8.6).
fn heartbeat(body: &[u8], little: bool) -> Result<(Entity, i64, i64), Reason> {
    let mut fields = Fields::new(body, little);
    fields.skip(4)?;
    Ok((fields.bytes()?, fields.number()?, fields.number()?))
}

/// The writer and number of a sample, and whether this is all or the last of it; `None` if the
/// submessage has no sample.
fn sample(message: &[u8], head: &Head) -> Option<(Entity, i64, bool)> {
    match head.kind {
        kind::DATA => {
            let mut fields = Fields::new(message.get(head.body.clone())?, head.little());
            fields.skip(8).ok()?;
            Some((fields.bytes().ok()?, fields.number().ok()?, true))
        }
        kind::DATA_FRAG => Cut::of(message, head).map(|cut| (cut.writer, cut.number, cut.last)),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::tests::forger::{Forger, USER, data, fragment, heartbeat};
    use super::*;

    const US: Forger = Forger(*b"\x01\x12ourselves.");

    struct World(Announced, Duration);

    impl World {
        fn new() -> Self {
            Self(Announced::default(), Duration::from_secs(9))
        }

        fn sends(&mut self, submessages: &[Vec<u8>]) {
            self.0.sent(&US.message(submessages));
        }

        /// One of the two fragments of a sample.
        fn sends_half(&mut self, number: i64, first: u32) {
            self.sends(&[fragment(USER, number, (first, 1, 1000), 1500, &[0; 500])]);
        }

        /// What the heartbeat says that announces these.
        fn says(&mut self, first: i64, last: i64) -> (i64, i64) {
            let message = US.message(&[heartbeat(USER, first, last, 1)]);
            let narrowed = self.0.narrowed(&message, || self.1).unwrap_or(message);
            let head = Head::read(&narrowed, HEADER).unwrap().unwrap();
            let (_, first, last) = super::heartbeat(&narrowed[head.body], true).unwrap();
            (first, last)
        }
    }

    #[test]
    fn a_large_sample_is_announced_only_when_all_of_it_was_sent() {
        let mut world = World::new();
        assert_eq!(world.says(1, 1), (1, 1), "nothing large was sent yet");
        world.sends_half(1, 1);
        assert_eq!(world.says(1, 1), (1, 0));
        world.sends_half(1, 2);
        assert_eq!(world.says(1, 1), (1, 1));
        assert_eq!(world.says(1, 2), (1, 1));
        assert_eq!(world.says(2, 3), (2, 1));
        world.sends_half(3, 2);
        assert_eq!(world.says(2, 3), (2, 3));
        world.sends(&[data(USER, 4, &[0, 1, 0, 0]), heartbeat(USER, 1, 4, 2)]);
        assert_eq!(world.says(2, 4), (2, 4));
    }

    #[test]
    fn what_is_not_sent_because_nobody_read_is_announced_all_the_same_to_a_late_reader() {
        let mut world = World::new();
        world.sends_half(1, 2);
        assert_eq!(world.says(1, 5), (1, 1));
        world.1 += LONGEST;
        assert_eq!(world.says(1, 5), (1, 5));
        // That is forgotten with the next sample.
        world.sends_half(6, 2);
        assert_eq!(world.says(1, 7), (1, 6));
    }

    #[test]
    fn writers_of_small_samples_and_built_in_ones_announce_what_they_want() {
        let mut world = World::new();
        world.sends(&[data(USER, 1, &[0, 1, 0, 0])]);
        assert_eq!(world.says(1, 9), (1, 9));
        world.sends(&[fragment([0, 0, 3, 0xc2], 1, (1, 1, 1000), 1500, &[0; 500])]);
        assert_eq!(world.says(1, 9), (1, 9));
    }
}
