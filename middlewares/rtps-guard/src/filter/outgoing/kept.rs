//! What was sent of large samples, for readers on this machine that lose parts of them.
//!
//! RustDDS 0.15.1 repairs 8 fragments of 256 bytes each 10 ms, or sends all of a sample again after
//! 200 ms (`repairs`). So once a reader loses parts, the datagrams of the last samples are kept here,
//! and those that it asks for go again at once.

use std::collections::VecDeque;

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

#[derive(Debug)]
struct Datagram {
    first: u32,
    end: u32,
    bytes: Vec<u8>,
}

#[derive(Debug)]
struct Sample {
    writer: Entity,
    number: i64,
    to: Vec<Target>,
    datagrams: Vec<Datagram>,
    size: usize,
    /// Bytes that were sent again.
    again: usize,
    /// Datagrams that go again beyond those of which the next request tells.
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
    /// Whether one of these fragments is missing.
    fn is_of(&self, first: u32, end: u32) -> bool {
        let numbers = self.missing.numbers().filter_map(|number| self.base.checked_add(number));
        let mut numbers = numbers;
        numbers.any(|number| (first..end).contains(&number))
    }

    /// The fragment after those that it tells of, if the last of them is missing and there was no
    /// room to tell of more.
    fn goes_on(&self) -> Option<u32> {
        let last = self.missing.numbers().last()?;
        (last + 1 == Bitmap::MOST).then(|| self.base.saturating_add(Bitmap::MOST))
    }
}

impl Kept {
    /// Keeps a datagram that was sent, with the fragments from the first to before the second.
    pub(crate) fn add(
        &mut self,
        (writer, number): (Entity, i64),
        to: &Target,
        (first, end): (u32, u32),
        bytes: &[u8],
    ) {
        let of = |sample: &Sample| (sample.writer, sample.number) == (writer, number);
        if !self.samples.iter().any(of) {
            let (to, datagrams) = (Vec::new(), Vec::new());
            let (size, again, beyond) = (0, 0, 1);
            self.samples.push_back(Sample { writer, number, to, datagrams, size, again, beyond });
        }
        let Some(sample) = self.samples.iter_mut().find(|sample| of(sample)) else { return };
        if !sample.to.contains(to) && sample.to.len() < TARGETS {
            sample.to.push(*to);
        }
        // What goes to several readers, or again, is kept once.
        if sample.datagrams.iter().any(|kept| kept.first <= first && end <= kept.end) {
            return;
        }
        sample.datagrams.push(Datagram { first, end, bytes: bytes.to_vec() });
        sample.size += bytes.len();
        self.size += bytes.len();
        let mut others = self.samples.iter().filter(|sample| sample.writer == writer);
        let many = others.clone().count() > SAMPLES;
        let oldest = others.next().map(|sample| sample.number);
        if many {
            self.remove(|sample| sample.writer == writer && Some(sample.number) == oldest);
        }
        while self.size > MOST && !self.samples.is_empty() {
            let mut oldest = true;
            self.remove(|_| std::mem::take(&mut oldest));
        }
    }

    fn remove(&mut self, mut of: impl FnMut(&Sample) -> bool) {
        self.samples.retain(|sample| !of(sample));
        self.size = self.samples.iter().map(|sample| sample.size).sum();
    }

    /// Sends again what a reader lacks. Returns false if it is not kept, or was sent too often.
    pub(crate) fn repair(&mut self, lack: &Lack, mut send: impl FnMut(&Target, &[u8])) -> bool {
        let of =
            |sample: &&mut Sample| (sample.writer, sample.number) == (lack.writer, lack.number);
        let Some(sample) = self.samples.iter_mut().find(of) else { return false };
        let Sample { to, datagrams, size, again, beyond, .. } = sample;
        if *again >= *size * TIMES {
            return false;
        }
        let mut sent = false;
        let mut more = 0;
        let goes_on = lack.goes_on();
        for Datagram { first, end, bytes } in &*datagrams {
            let follows = goes_on.is_some_and(|from| *first >= from) && more < *beyond;
            more += usize::from(follows);
            if follows || lack.is_of(*first, *end) {
                to.iter().for_each(|to| send(to, bytes));
                *again += bytes.len();
                sent = true;
            }
        }
        if goes_on.is_some() {
            // Much is missing, and each request tells of little.
            *beyond = beyond.saturating_mul(2);
        }
        sent
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
                        kept.add((writer, number), &TO, (part * 9 + 1, part * 9 + 10), &datagram);
                    }
                }
            }
        }
        let numbers: Vec<i64> = kept.samples.iter().map(|sample| sample.number).collect();
        assert_eq!(numbers, [48, 48, 49, 49]);
        assert_eq!(kept.size, 4 * 10 * datagram.len());
        for writer in 0..200 {
            for part in 0..10 {
                kept.add(([1, 0, writer, 3], 1), &TO, (part + 1, part + 2), &datagram);
                assert!(kept.size <= MOST);
            }
        }
        assert!(kept.size > MOST / 2 && kept.samples.len() > 50);
        kept.clear();
        assert!(kept.is_empty() && kept.size == 0);
    }
}
