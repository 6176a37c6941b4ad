//! Which sample that a codel read is which one that another codel wrote, and how long it was under
//! way.
//!
//! Samples carry no numbers that all middlewares keep, so they are recognised by digests of their
//! contents, in the order in which they were read. If several samples have the same content, one
//! that was read is taken for the newest that had been written by then (policy `latest`), or for
//! the oldest that was not read yet (`queue`, `ring`); such pairs are counted.

use std::collections::HashMap;

use genom_protocol::Policy;
use genom_protocol::frames::Times;

/// The samples of a connection, in nanoseconds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// From the beginning of `write` to the end of the `read` that returned the sample.
    pub latencies: Vec<u64>,
    /// The same without the time that the sample could have been read but nobody did.
    pub hops: Vec<u64>,
    /// Samples written from the first to the last one that was read.
    pub sent: u64,
    /// Those of them that were never read: lost, or replaced by newer ones.
    pub skipped: u64,
    /// Pairs for which another written sample of the same content would have fit, too.
    pub alike: u64,
    /// Samples read that were written before the recording began, or whose record was lost.
    pub unknown: u64,
}

impl Pairs {
    /// Finds the pairs of what a writer wrote and what a reader read, each in order.
    #[must_use]
    pub fn of(written: &[Times], read: &[Times], policy: Policy) -> Self {
        let mut places: HashMap<u64, Vec<usize>> = HashMap::new();
        for (place, sample) in written.iter().enumerate() {
            places.entry(sample.digest).or_default().push(place);
        }
        let mut pairs = Self::default();
        let (mut first, mut next) = (None, 0);
        for sample in read {
            let all = places.get(&sample.digest).map_or(&[][..], Vec::as_slice);
            let begin = all.partition_point(|place| *place < next);
            let known = sample.arrived.unwrap_or(sample.ended);
            let before = |place: &usize| written.get(*place).is_some_and(|one| one.begun <= known);
            let end = all.partition_point(before).max(begin);
            let fits = all.get(begin..end).unwrap_or_default();
            let place = match policy {
                Policy::Latest => fits.last(),
                Policy::Queue(_) | Policy::Ring(_) => fits.first(),
            };
            let Some((place, from)) = place.and_then(|place| Some((*place, written.get(*place)?)))
            else {
                pairs.unknown += 1;
                continue;
            };
            pairs.alike += u64::from(fits.len() > 1);
            pairs.latencies.push(sample.ended.saturating_sub(from.begun));
            pairs.hops.push(hop(from, sample));
            first.get_or_insert(place);
            next = place + 1;
        }
        pairs.sent = (next - first.unwrap_or(next)) as u64;
        pairs.skipped = pairs.sent - pairs.latencies.len() as u64;
        pairs
    }

    /// Adds what another run found.
    pub fn add(&mut self, other: Self) {
        self.latencies.extend(other.latencies);
        self.hops.extend(other.hops);
        self.sent += other.sent;
        self.skipped += other.skipped;
        self.alike += other.alike;
        self.unknown += other.unknown;
    }
}

/// How long a sample was under way, in nanoseconds, without the time that it waited to be read.
fn hop(from: &Times, to: &Times) -> u64 {
    let there = to.arrived.unwrap_or(from.ended);
    let waited = to.begun.saturating_sub(there);
    to.ended.saturating_sub(from.begun).saturating_sub(waited)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(begun: u64, digest: u64) -> Times {
        Times { begun, ended: begun + 2, arrived: None, digest }
    }

    fn read(begun: u64, arrived: Option<u64>, digest: u64) -> Times {
        Times { begun, ended: begun + 3, arrived, digest }
    }

    #[test]
    fn a_sample_is_found_by_its_content_and_those_between_were_skipped() {
        let wrote: Vec<Times> = (0..5).map(|n| written(n * 100, n)).collect();
        let got = [read(150, Some(110), 1), read(450, Some(410), 4)];
        let pairs = Pairs::of(&wrote, &got, Policy::Latest);
        assert_eq!(pairs.latencies, [53, 53]);
        // 40 of them it waited for its reader.
        assert_eq!(pairs.hops, [13, 13]);
        assert_eq!((pairs.sent, pairs.skipped, pairs.alike, pairs.unknown), (4, 2, 0, 0));
    }

    #[test]
    fn where_arrivals_are_not_known_a_sample_is_there_when_its_write_ended() {
        let pairs = Pairs::of(&[written(0, 7)], &[read(50, None, 7)], Policy::Latest);
        assert_eq!((pairs.latencies[0], pairs.hops[0]), (53, 2 + 3));
        // It came while the codel was reading: nothing was waited.
        let pairs = Pairs::of(&[written(0, 7)], &[read(1, Some(2), 7)], Policy::Latest);
        assert_eq!((pairs.latencies[0], pairs.hops[0]), (4, 4));
    }

    #[test]
    fn of_equal_contents_the_policy_says_which_was_read() {
        let wrote = [written(0, 7), written(100, 7), written(200, 7)];
        let latest = Pairs::of(&wrote, &[read(150, None, 7)], Policy::Latest);
        assert_eq!((latest.latencies[0], latest.alike), (53, 1));
        let queue = Pairs::of(&wrote, &[read(150, None, 7), read(160, None, 7)], Policy::Queue(9));
        assert_eq!((queue.latencies.as_slice(), queue.alike), (&[153, 63][..], 1));
    }

    #[test]
    fn nothing_is_read_before_it_is_written_nor_twice() {
        let wrote = [written(100, 7)];
        let got = [read(0, None, 7), read(150, None, 7), read(250, None, 7), read(300, None, 8)];
        let pairs = Pairs::of(&wrote, &got, Policy::Latest);
        assert_eq!((pairs.latencies.as_slice(), pairs.unknown), (&[53][..], 3));
        assert_eq!(Pairs::of(&[], &[], Policy::Latest), Pairs::default());
    }
}
