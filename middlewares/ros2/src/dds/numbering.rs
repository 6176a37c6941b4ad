//! Numbers samples, so that a reader can count those that it lost.
//!
//! A DDS writer numbers its messages (RTPS 2.5, 8.3.5.4), and numbers that a reader does not get
//! are lost samples, except those of messages to a single other reader: an out port of genomd sends
//! its last value to each late reader. So genomd's writers count these messages modulo 256, and put
//! the count into the lowest bits of each message's timestamp (60 ns). A parameter in the message
//! is not possible: RustDDS cannot send one together with fragments that fill a datagram. Writers
//! of other implementations number samples only.

use crate::dds::rustdds::{GUID, Timestamp, WriteOptions, WriteOptionsBuilder};

/// Number of low bits of a timestamp that hold the count. Timestamps that differ only there belong
/// to the same sample.
const BITS: u32 = 8;
const TOLD: u64 = (1 << BITS) - 1;

/// The messages of one writer.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Numbering {
    /// Timestamp of the last sample, without the count.
    last: u64,
    /// Number of messages to single readers so far, modulo 256.
    repeated: u8,
}

impl Numbering {
    /// Options for the next sample. Each sample has a unique timestamp, by which readers recognise
    /// duplicates.
    pub(crate) fn next(&mut self, now: Timestamp) -> WriteOptions {
        self.last = (now.to_ticks() & !TOLD).max(self.last + (1 << BITS));
        self.options().build()
    }

    /// Options for sending the last sample again, to this reader.
    pub(crate) fn again(&mut self, reader: GUID) -> WriteOptions {
        self.repeated = self.repeated.wrapping_add(1);
        self.options().to_single_reader(reader).build()
    }

    fn options(&self) -> WriteOptionsBuilder {
        let told = self.last | u64::from(self.repeated);
        WriteOptionsBuilder::new().source_timestamp(Timestamp::from_ticks(told))
    }
}

/// The position of a message among those of its writer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Place {
    number: i64,
    time: Option<u64>,
}

impl Place {
    pub(crate) fn new(number: i64, time: Option<Timestamp>) -> Self {
        Self { number, time: time.map(Timestamp::to_ticks) }
    }

    /// Whether it is newer than `last`. A recreated reader gets messages again that DDS still
    /// holds, and a new reader gets the last sample twice.
    pub(crate) fn is_after(&self, last: &Self) -> bool {
        let sample = |place: &Self| place.time.map(|time| time >> BITS);
        self.number > last.number && (self.time.is_none() || sample(self) != sample(last))
    }

    /// Number of samples between this message and a later one. Single-reader messages are
    /// subtracted if the writer is a genomd.
    pub(crate) fn missing(&self, next: &Self, genomd: bool) -> u64 {
        let told = |place: &Self| place.time.map_or(0, |time| (time & TOLD) as u8);
        let repeated = if genomd { told(next).wrapping_sub(told(self)) } else { 0 };
        let between = next.number.saturating_sub(self.number).saturating_sub(1);
        // A peer may send any number.
        let missing = u64::try_from(between).unwrap_or(0).saturating_sub(u64::from(repeated));
        missing.min(u64::from(u32::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(number: i64, time: u64) -> Place {
        Place { number, time: Some(time) }
    }

    #[test]
    fn messages_to_other_readers_leave_no_hole() {
        let mut numbering = Numbering::default();
        let reader = GUID::GUID_UNKNOWN;
        let mut number = 0;
        let mut sent = |options: WriteOptions| {
            number += 1;
            Place::new(number, options.source_timestamp())
        };
        let now = Timestamp::now();
        let one = sent(numbering.next(now));
        let two = sent(numbering.next(now));
        let to_others: Vec<_> = (0..300).map(|_| sent(numbering.again(reader))).collect();
        let three = sent(numbering.next(now));
        let four = sent(numbering.next(now));
        assert_eq!((one.missing(&two, true), three.missing(&four, true)), (0, 0));
        assert_eq!(two.missing(&to_others[100], true), 0);
        assert_eq!(to_others[299].missing(&three, true), 0);
        assert_eq!(to_others[200].missing(&four, true), 1);
        // They all carry the second sample.
        assert_eq!(one.missing(&to_others[9], true), 0);
        assert!(two.is_after(&one) && three.is_after(&two));
        assert!(to_others.iter().all(|again| !again.is_after(&two) && again.is_after(&one)));
    }

    #[test]
    fn other_makes_number_samples_and_a_peer_may_say_anything() {
        assert_eq!(place(3, 1).missing(&place(9, 4), false), 5);
        assert_eq!(place(3, 1).missing(&place(9, 0), true), 0);
        assert_eq!(place(9, 1).missing(&place(3, 4), false), 0);
        assert_eq!(place(1, 0).missing(&place(i64::MAX, 0), true), u64::from(u32::MAX));
        assert_eq!(place(i64::MIN, 0).missing(&place(i64::MAX, 0), false), u64::from(u32::MAX));
        let timeless = |number| Place { number, time: None };
        assert!(timeless(2).is_after(&timeless(1)) && !timeless(1).is_after(&timeless(1)));
    }
}
