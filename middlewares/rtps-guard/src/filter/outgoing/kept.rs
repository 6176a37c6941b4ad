//! What was sent of large samples, for readers that lose parts of them.
//!
//! RustDDS 0.15.1 repairs 8 fragments of 256 bytes each 10 ms, or sends all of a sample again after
//! 200 ms (`repairs`). So once a reader loses parts, the datagrams of the last samples are kept here,
//! and those that it asks for go again at once.

use std::collections::{BTreeMap, VecDeque};

use super::super::message::{Bitmap, Entity};
use super::wire::Target;

/// Bytes of all samples that are kept, and how many of one writer.
const MOST: usize = 64 << 20;
const SAMPLES: usize = 2;

/// How often as many bytes as a sample has may be sent again. After that RustDDS has to repair it:
/// requests can be forged, or a reader may be unable to take a sample.
const TIMES: usize = 4;

/// Addresses to which a sample was sent.
const TARGETS: usize = 64;

/// Bytes that go again beyond those of which the first request tells.
const BEYOND: usize = 64 << 10;

/// A sample as it goes to readers on this machine, or to others: its writer and number.
pub(crate) type Of = (Entity, i64, bool);

#[derive(Debug)]
struct Sample {
    of: Of,
    to: Vec<Target>,
    /// By their first fragment, with the one after their last.
    datagrams: BTreeMap<u32, (u32, Vec<u8>)>,
    size: usize,
    /// Bytes that were sent again.
    again: usize,
    /// Bytes that go again beyond those of which the next request tells.
    beyond: usize,
}

#[derive(Debug, Default)]
pub(crate) struct Kept {
    samples: VecDeque<Sample>,
    size: usize,
}

/// What a reader lacks of a sample (NACK_FRAG, 8.3.8.10).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lack {
    pub(crate) writer: Entity,
    pub(crate) number: i64,
    /// The first fragment that it tells of.
    pub(crate) base: u32,
    pub(crate) missing: Bitmap,
}

impl Lack {
    /// The fragment after those that it tells of, if the last of them is missing and there was no
    /// room to tell of more.
    fn goes_on(&self) -> Option<u32> {
        let last = self.missing.numbers().last()?;
        (last + 1 == Bitmap::MOST).then(|| self.base.saturating_add(Bitmap::MOST))
    }
}

impl Kept {
    /// Keeps a datagram that was sent, with the fragments from the first to before the second.
    pub(crate) fn add(&mut self, of: Of, to: &Target, (first, end): (u32, u32), bytes: &[u8]) {
        if !self.samples.iter().any(|sample| sample.of == of) {
            let (to, datagrams) = (Vec::new(), BTreeMap::new());
            let (size, again, beyond) = (0, 0, BEYOND);
            self.samples.push_back(Sample { of, to, datagrams, size, again, beyond });
        }
        let Some(sample) = self.samples.iter_mut().find(|sample| sample.of == of) else { return };
        if !sample.to.contains(to) && sample.to.len() < TARGETS {
            sample.to.push(*to);
        }
        // What goes to several readers, or again, is kept once.
        if sample.datagrams.contains_key(&first) {
            return;
        }
        sample.datagrams.insert(first, (end, bytes.to_vec()));
        sample.size += bytes.len();
        self.size += bytes.len();
        let (writer, _, here) = of;
        let is_of_writer = |sample: &Sample| (sample.of.0, sample.of.2) == (writer, here);
        let mut others = self.samples.iter().filter(|sample| is_of_writer(sample));
        if others.clone().count() > SAMPLES
            && let Some(oldest) = others.next().map(|sample| sample.of)
        {
            self.remove(|sample| sample.of == oldest);
        }
        while self.size > MOST
            && let Some(oldest) = self.samples.front().map(|sample| sample.of)
        {
            self.remove(|sample| sample.of == oldest);
        }
    }

    fn remove(&mut self, of: impl Fn(&Sample) -> bool) {
        self.samples.retain(|sample| !of(sample));
        self.size = self.samples.iter().map(|sample| sample.size).sum();
    }

    /// Sends again what a reader, on this machine or not, lacks. Returns false if it is not kept, or
    /// was sent too often.
    pub(crate) fn repair(
        &mut self,
        lack: &Lack,
        here: bool,
        mut send: impl FnMut(&Target, &[u8]),
    ) -> bool {
        let of = (lack.writer, lack.number, here);
        let Some(sample) = self.samples.iter_mut().find(|sample| sample.of == of) else {
            return false;
        };
        let Sample { to, datagrams, size, again, beyond, .. } = sample;
        if *again >= *size * TIMES {
            return false;
        }
        let has = |number: u32| {
            let (first, (end, _)) = datagrams.range(..=number).next_back()?;
            (number < *end).then_some(*first)
        };
        let missing = lack.missing.numbers().filter_map(|number| lack.base.checked_add(number));
        let mut firsts: Vec<u32> = missing.filter_map(has).collect();
        firsts.dedup();
        if let Some(from) = lack.goes_on() {
            // Much is missing, and each request tells of little.
            let mut more = 0;
            firsts.extend(
                datagrams
                    .range(from..)
                    .take_while(|(_, (_, bytes))| {
                        more += bytes.len();
                        more <= *beyond
                    })
                    .map(|(first, _)| *first),
            );
            *beyond = beyond.saturating_mul(2);
        }
        for first in &firsts {
            if let Some((_, bytes)) = datagrams.get(first) {
                to.iter().for_each(|to| send(to, bytes));
                *again += bytes.len();
            }
        }
        !firsts.is_empty()
    }

    /// Forgets all.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.samples.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, SocketAddrV4};

    use super::*;

    const TO: Target = Target { socket: 3, address: SocketAddrV4::new(Ipv4Addr::LOCALHOST, 7411) };

    #[test]
    fn the_last_samples_of_each_writer_are_kept_up_to_a_limit() {
        let mut kept = Kept::default();
        let datagram = vec![7; 60_000];
        for number in 1..50 {
            for writer in [[0, 0, 1, 3], [0, 0, 2, 3]] {
                for part in 0..10 {
                    // What goes to another reader, too, is there once.
                    for _ in 0..2 {
                        kept.add(
                            (writer, number, true),
                            &TO,
                            (part * 9 + 1, part * 9 + 10),
                            &datagram,
                        );
                    }
                }
            }
        }
        let numbers: Vec<i64> = kept.samples.iter().map(|sample| sample.of.1).collect();
        assert_eq!(numbers, [48, 48, 49, 49]);
        assert_eq!(kept.size, 4 * 10 * datagram.len());
        for writer in 0..200 {
            for part in 0..10 {
                kept.add(([1, 0, writer, 3], 1, false), &TO, (part + 1, part + 2), &datagram);
                assert!(kept.size <= MOST);
            }
        }
        assert!(kept.size > MOST / 2 && kept.samples.len() > 50);
        kept.clear();
        assert!(kept.is_empty() && kept.size == 0);
    }
}
