//! Which entries and which bytes for heads are free. Known to the process that writes only; a
//! black box is not read from it.

use std::collections::{BTreeMap, VecDeque};

use crate::layout::{HEADS, LONGEST_HEAD};

/// Heads take multiples of this.
const UNIT: usize = 64;

/// What is free.
#[derive(Debug)]
pub(crate) struct Plan {
    /// Length of each free piece of the heads, by its offset.
    free: BTreeMap<usize, usize>,
    /// Entries that were never used begin here.
    fresh: usize,
    /// Entries that no track has, and whose heads were removed.
    unused: Vec<usize>,
    /// Those that no track has any more, the oldest first, with their heads.
    closed: VecDeque<Entry>,
    /// Tracks.
    open: usize,
    most: usize,
}

/// An entry with the piece of the heads that it has.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entry {
    pub(crate) index: usize,
    pub(crate) at: usize,
    room: usize,
}

/// Why there is no entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Full {
    Entries,
    Heads,
}

impl Plan {
    /// With `entries` entries, of which half may be used at once: the rest of the blocks goes
    /// round.
    pub(crate) fn new(entries: usize) -> Self {
        Self {
            free: BTreeMap::from([(0, HEADS)]),
            fresh: 0,
            unused: Vec::new(),
            closed: VecDeque::new(),
            open: 0,
            most: entries / 2,
        }
    }

    /// An entry with room for a head; entries that no track has any more make room for it, and are
    /// passed to `removed`.
    pub(crate) fn take(
        &mut self,
        length: usize,
        mut removed: impl FnMut(usize),
    ) -> Result<Entry, Full> {
        if self.open >= self.most {
            return Err(Full::Entries);
        }
        let room = length.max(1).next_multiple_of(UNIT);
        if length > LONGEST_HEAD {
            return Err(Full::Heads);
        }
        let mut remove = |plan: &mut Self| {
            let oldest = plan.closed.pop_front();
            oldest.inspect(|oldest| {
                removed(oldest.index);
                plan.give_back(*oldest);
                plan.unused.push(oldest.index);
            })
        };
        let at = loop {
            let fits = self.free.iter().find(|(_, length)| **length >= room);
            match fits.map(|(at, length)| (*at, *length)) {
                Some((at, length)) => {
                    self.free.remove(&at);
                    if length > room {
                        self.free.insert(at + room, length - room);
                    }
                    break at;
                }
                None if remove(self).is_some() => {}
                None => return Err(Full::Heads),
            }
        };
        if self.unused.is_empty() && self.fresh >= 2 * self.most {
            remove(self);
        }
        let index = match self.unused.pop() {
            Some(index) => index,
            None => {
                self.fresh += 1;
                self.fresh - 1
            }
        };
        self.open += 1;
        Ok(Entry { index, at, room })
    }

    /// The track of this entry is gone; what it wrote can still be read.
    pub(crate) fn close(&mut self, entry: Entry) {
        self.open -= 1;
        self.closed.push_back(entry);
    }

    fn give_back(&mut self, Entry { at, room, .. }: Entry) {
        let (mut at, mut room) = (at, room);
        if let Some(after) = self.free.remove(&(at + room)) {
            room += after;
        }
        let before = self.free.range(..at).next_back().map(|(at, length)| (*at, *length));
        if let Some((start, length)) = before
            && start + length == at
        {
            self.free.remove(&start);
            (at, room) = (start, length + room);
        }
        self.free.insert(at, room);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_entries_stay_until_their_place_is_needed_and_go_oldest_first() {
        let mut plan = Plan::new(8);
        let all: Vec<Entry> = (0..4).map(|_| plan.take(100, |_| panic!("none")).unwrap()).collect();
        assert_eq!(plan.take(100, |_| panic!("none")).unwrap_err(), Full::Entries);
        all.iter().for_each(|entry| plan.close(*entry));
        let mut removed = Vec::new();
        for _ in 0..20 {
            let entry = plan.take(100, |index| removed.push(index)).unwrap();
            assert!(entry.index < 8);
            plan.close(entry);
        }
        assert_eq!(removed[..4], [0, 1, 2, 3]);
    }

    #[test]
    fn heads_that_are_given_back_join() {
        let mut plan = Plan::new(4096);
        let mut all = Vec::new();
        while let Ok(entry) = plan.take(LONGEST_HEAD, |_| {}) {
            all.push(entry);
        }
        assert_eq!(all.len(), HEADS / LONGEST_HEAD);
        all.iter().for_each(|entry| plan.close(*entry));
        assert_eq!(plan.take(LONGEST_HEAD + 1, |_| {}).unwrap_err(), Full::Heads);
        let again = (0..all.len()).filter(|_| plan.take(LONGEST_HEAD, |_| {}).is_ok()).count();
        assert_eq!((again, plan.free.len()), (all.len(), 0));
    }
}
