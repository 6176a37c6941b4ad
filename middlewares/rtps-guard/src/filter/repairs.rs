//! Large samples that a reader of ours misses parts of: what RustDDS 0.15.1 makes of such requests.
//!
//! RustDDS answers a NACK_FRAG with 8 fragments of 256 bytes each 10 ms (`rtps/writer.rs`,
//! `handle_repair_frags_send_worker`), 0.2 MB a second. A reader that lost a part of an image never
//! catches up. A request for the whole sample, an ACKNACK, is answered at once with all of it. So
//! where more is missing than the trickle brings soon, a NACK_FRAG becomes an ACKNACK.
//!
//! Beside its NACK_FRAGs a reader acknowledges what it has, with an ACKNACK that asks for nothing.
//! RustDDS answers each of these at once with a heartbeat, to which the reader answers with the
//! same again, as fast as both can. Of equal ones only the first passes while parts are missing.

use std::collections::HashMap;
use std::time::Duration;

use super::answer::Answer;
use super::limits::FLOWS;
use super::message::{Entity, Fields, Prefix, kind, put_number};
use super::tally::Reason;

/// Fragments that RustDDS is left to send one by one: within 80 ms.
const FEW: u32 = 64;

/// Time in which a sample that was sent again should have arrived, and how far it grows if it has
/// not: the network may be slow.
const PAUSE: (Duration, Duration) = (Duration::from_millis(100), Duration::from_secs(2));

/// Bytes of an ACKNACK without its bitmap, and numbers that it can name.
const ACKNACK: usize = 24;
const NUMBERS: i64 = 256;

/// A reader, and the writer of ours that it reads.
type Pair = (Prefix, Entity, Entity);

#[derive(Debug, Default)]
struct State {
    /// It has all samples before this one.
    base: i64,
    /// The first sample of which it said that parts are missing.
    partial: Option<i64>,
    /// The sample that is sent again, since when, and for how long no other is.
    again: Option<(i64, Duration, Duration)>,
}

#[derive(Debug, Default)]
pub(crate) struct Repairs(HashMap<Pair, State>);

impl Repairs {
    fn of(&mut self, pair: Pair) -> Option<&mut State> {
        if self.0.len() >= FLOWS && !self.0.contains_key(&pair) {
            return None;
        }
        Some(self.0.entry(pair).or_default())
    }

    /// A reader has all before `base`; `asks` whether it asks for samples.
    fn acknack(&mut self, pair: Pair, base: i64, asks: bool) -> Answer {
        let Some(state) = self.of(pair) else { return Answer::Pass };
        let same = state.base == base && state.partial == Some(base);
        if base > state.base {
            state.base = base;
            state.partial = state.partial.filter(|number| *number >= base);
        }
        if same && !asks { Answer::Drop } else { Answer::Pass }
    }

    /// A reader lacks at least `missing` fragments of a sample.
    pub(crate) fn nack_frag(
        &mut self,
        pair: Pair,
        number: i64,
        missing: u32,
        now: Duration,
    ) -> Answer {
        let Some(state) = self.of(pair) else { return Answer::Pass };
        state.partial = Some(state.partial.map_or(number, |partial| partial.min(number)));
        // Without an acknowledgement it is not known what an ACKNACK may say that it has.
        let known = state.base > 0 && (0..NUMBERS).contains(&(number - state.base));
        if missing <= FEW || !known {
            return Answer::Pass;
        }
        let pause = match state.again {
            Some((again, since, pause)) if again >= state.base => {
                if now.saturating_sub(since) < pause {
                    return Answer::Drop;
                }
                if again == number { (pause * 2).min(PAUSE.1) } else { PAUSE.0 }
            }
            _ => PAUSE.0,
        };
        state.again = Some((number, now, pause));
        Answer::Whole { base: state.base, number }
    }

    /// Reads an ACKNACK (8.3.8.1), from its set on.
    pub(crate) fn read_acknack(
        &mut self,
        pair: Pair,
        fields: &mut Fields<'_>,
    ) -> Result<Answer, Reason> {
        let base = fields.number()?;
        let asks = fields.bitmap()?.count() > 0;
        fields.u32()?;
        Ok(self.acknack(pair, base, asks))
    }

    /// Forgets the readers of a participant that is gone.
    pub(crate) fn forget(&mut self, participant: &Prefix) {
        self.0.retain(|(prefix, ..), _| prefix != participant);
    }
}

/// Turns a NACK_FRAG, which begins at `start` of a message, into an ACKNACK for the whole sample,
/// and what is left of it into padding. Returns false if there is no room for that.
pub(crate) fn ask_for_whole(message: &mut [u8], start: usize, base: i64, number: i64) -> bool {
    const HEAD: usize = 4;
    let Some(&[_, flags, a, b]) = message.get(start..).and_then(<[u8]>::first_chunk) else {
        return false;
    };
    let little = flags & 1 == 1;
    let two = |bytes| if little { u16::from_le_bytes(bytes) } else { u16::from_be_bytes(bytes) };
    let four = |number: u32| if little { number.to_le_bytes() } else { number.to_be_bytes() };
    let short = |n: u16| if little { n.to_le_bytes() } else { n.to_be_bytes() };
    let old = usize::from(two([a, b]));
    let Ok(bit) = u32::try_from(number - base) else { return false };
    let words = bit as usize / 32 + 1;
    let new = ACKNACK + 4 * words;
    let room = message.get_mut(start..start + HEAD + old);
    // What is left has room for the header of the padding, or there is nothing left.
    let Some(room) = room.filter(|_| old == new || old >= new + HEAD) else { return false };
    let (Some(count), Some(lengths)) = (
        room.last_chunk::<4>().copied(),
        u16::try_from(new).ok().zip(u16::try_from(old.saturating_sub(new + HEAD)).ok()),
    ) else {
        return false;
    };
    // The reader and the writer are in the same place in both.
    let (head, body) = room.split_at_mut(HEAD);
    let [c, d] = short(lengths.0);
    // The flag "final": the reader does not wait for a heartbeat.
    head.copy_from_slice(&[kind::ACKNACK, (flags & 1) | 2, c, d]);
    put_number(body, 8, little, base);
    let mut put = |at: usize, bytes: [u8; 4]| {
        if let Some(place) = body.get_mut(at..at + 4) {
            place.copy_from_slice(&bytes);
        }
    };
    put(16, four(bit + 1));
    for word in 0..words {
        let last = word == words - 1;
        put(20 + 4 * word, four(if last { 1 << (31 - bit % 32) } else { 0 }));
    }
    put(20 + 4 * words, count);
    if old > new {
        let [c, d] = short(lengths.1);
        put(new, [kind::PAD, flags & 1, c, d]);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAIR: Pair = ([1; 12], [0, 0, 1, 4], [0, 0, 2, 3]);

    fn at(millis: u64) -> Duration {
        Duration::from_millis(9_000 + millis)
    }

    #[test]
    fn a_reader_that_lost_much_of_a_sample_is_sent_all_of_it_again() {
        let mut repairs = Repairs::default();
        assert_eq!(repairs.acknack(PAIR, 3, false), Answer::Pass);
        let whole = Answer::Whole { base: 3, number: 4 };
        assert_eq!(repairs.nack_frag(PAIR, 4, 255, at(0)), whole);
        // Until it has arrived, or should have.
        assert_eq!(repairs.nack_frag(PAIR, 4, 255, at(50)), Answer::Drop);
        assert_eq!(repairs.nack_frag(PAIR, 5, 255, at(50)), Answer::Drop);
        assert_eq!(repairs.nack_frag(PAIR, 4, 255, at(100)), whole);
        assert_eq!(repairs.nack_frag(PAIR, 4, 255, at(250)), Answer::Drop);
        assert_eq!(repairs.nack_frag(PAIR, 4, 255, at(300)), whole);
        assert_eq!(repairs.acknack(PAIR, 5, false), Answer::Pass);
        let next = Answer::Whole { base: 5, number: 5 };
        assert_eq!(repairs.nack_frag(PAIR, 5, 255, at(310)), next);
    }

    #[test]
    fn few_fragments_and_readers_that_acknowledged_nothing_are_left_to_dds() {
        let mut repairs = Repairs::default();
        assert_eq!(repairs.nack_frag(PAIR, 4, 255, at(0)), Answer::Pass);
        assert_eq!(repairs.acknack(PAIR, 1, false), Answer::Pass);
        assert_eq!(repairs.nack_frag(PAIR, 4, FEW, at(0)), Answer::Pass);
        assert_eq!(repairs.nack_frag(PAIR, 400, 255, at(0)), Answer::Pass);
    }

    #[test]
    fn the_same_acknowledgement_is_dropped_only_while_parts_are_missing() {
        let mut repairs = Repairs::default();
        for _ in 0..3 {
            assert_eq!(repairs.acknack(PAIR, 3, false), Answer::Pass);
        }
        repairs.nack_frag(PAIR, 3, 255, at(0));
        assert_eq!(repairs.acknack(PAIR, 3, false), Answer::Drop);
        assert_eq!(repairs.acknack(PAIR, 3, true), Answer::Pass);
        assert_eq!(repairs.acknack(PAIR, 4, false), Answer::Pass);
        assert_eq!(repairs.acknack(PAIR, 4, false), Answer::Pass);
        repairs.nack_frag(PAIR, 4, 255, at(0));
        repairs.forget(&PAIR.0);
        assert_eq!(repairs.acknack(PAIR, 4, false), Answer::Pass);
    }

    /// A NACK_FRAG with so many words of its bitmap.
    fn nack_frag(words: u32, little: bool) -> Vec<u8> {
        let four = |n: u32| if little { n.to_le_bytes() } else { n.to_be_bytes() };
        let mut body = [[0, 0, 1, 4], [0, 0, 2, 3]].concat();
        for number in [0, 40, 9946, words * 32] {
            body.extend(four(number));
        }
        body.extend((0..words).flat_map(|_| [0xff; 4]));
        body.extend(four(77));
        let length = u16::try_from(body.len()).unwrap();
        let length = if little { length.to_le_bytes() } else { length.to_be_bytes() };
        [&[kind::NACK_FRAG, u8::from(little), length[0], length[1]][..], &body].concat()
    }

    #[test]
    fn the_request_for_the_whole_sample_is_a_valid_one_in_both_byte_orders() {
        for (words, base, little) in
            [(1, 40, true), (1, 9, false), (8, 9, true), (8, 1, false), (2, 1, true)]
        {
            let mut message = nack_frag(words, little);
            let before = message.len();
            assert!(ask_for_whole(&mut message, 0, base, 40), "{words} {base}");
            assert_eq!(message.len(), before);
            let head = super::super::message::Head::read(&message, 0).unwrap().unwrap();
            assert_eq!((head.kind, head.little()), (kind::ACKNACK, little));
            let mut fields = Fields::new(&message[head.body.clone()], little);
            assert_eq!(fields.bytes(), Ok([0, 0, 1, 4]));
            assert_eq!(fields.bytes(), Ok([0, 0, 2, 3]));
            assert_eq!(fields.number(), Ok(base));
            let mut set = fields.clone();
            assert_eq!(set.bitmap().unwrap().count(), 1);
            let bits = fields.u32().unwrap();
            assert_eq!(i64::from(bits), 40 - base + 1);
            for _ in 1..bits.div_ceil(32) {
                assert_eq!(fields.u32(), Ok(0));
            }
            assert_eq!(fields.u32(), Ok(1 << (31 - (bits - 1) % 32)));
            assert_eq!(fields.u32(), Ok(77));
            if head.body.end < message.len() {
                let rest = super::super::message::Head::read(&message, head.body.end);
                let rest = rest.unwrap().unwrap();
                assert_eq!((rest.kind, rest.body.end), (kind::PAD, message.len()));
            }
        }
        // No room.
        assert!(!ask_for_whole(&mut nack_frag(1, true), 0, 1, 200));
        assert!(!ask_for_whole(&mut nack_frag(1, true)[..20], 0, 39, 40));
        assert!(!ask_for_whole(&mut [], 0, 39, 40));
    }
}
