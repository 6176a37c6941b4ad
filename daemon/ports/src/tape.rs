//! Carries samples from a codel's thread to a recording, as CDR in a ring buffer of bytes.
//!
//! The codel never waits and, for types of fixed size, allocates nothing. Samples for which the
//! ring has no room are dropped and counted.
//!
//! A recording of times has, in place of contents, when each sample was written or read and a digest
//! of it, so that much data does not disturb what is measured.
//!
//! A tape of a black box has a [`Track`] instead of a ring: it keeps the latest samples where a
//! crash of this process does not reach, and nobody empties it.

use std::hash::Hasher as _;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use genom_blackbox::Track;
use genom_protocol::frames::Times;
use genom_types::{DataType, Record};
use rtrb::{Consumer, Producer, RingBuffer};
use rustc_hash::FxHasher;

use crate::dates::Dates;

/// Bytes before each sample: moment (`u64`), number (`u32`), length of the message (`u32`), little
/// endian.
const HEAD: usize = 16;
/// Capacity of a ring in samples of fixed size: one second of a 1 kHz port.
const SAMPLES: usize = 1024;
/// Limits of the size of a ring, in bytes. Pages that are never written take no memory.
const SMALLEST: usize = 256 << 10;
const GREATEST: usize = 64 << 20;
/// Size of the ring for a type of variable size, in bytes.
const VARIABLE: usize = 16 << 20;

/// The writing end, used by the codel's thread.
pub struct Tape {
    session: u64,
    dates: Dates,
    /// The sample with its head; kept to reuse its memory.
    scratch: Vec<u8>,
    to: To,
}

/// Where samples go.
enum To {
    Recording { ring: Producer<u8>, number: u32, lost: Arc<AtomicU64>, what: What },
    BlackBox(Track),
}

/// What a recording has of each sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum What {
    /// Its content, as CDR.
    #[default]
    Contents,
    /// [`Times`] in place of the content.
    Times,
}

/// What is known of the way of a sample, on the machine's monotonic clock in nanoseconds.
#[derive(Clone, Copy, Debug, Default)]
pub struct Way {
    /// When the write or the read began; only if a tape asks for it ([`Tapes::begin`]).
    pub begun: Option<u64>,
    /// Of a read: when the sample arrived, if the middleware knows.
    pub arrived: Option<u64>,
}

/// The reading end, used by the recording's thread.
pub struct Reel {
    ring: Consumer<u8>,
    lost: Arc<AtomicU64>,
    scratch: Vec<u8>,
}

/// A recorded sample.
pub struct Sample<'a> {
    /// When it was taken: see [`Dates::moment`].
    pub moment: u64,
    /// Number of the sample, from 0; dropped samples have numbers, too.
    pub number: u32,
    /// CDR with its encapsulation header.
    pub message: &'a [u8],
}

/// The two ends of a tape for values of type `ty`, for the recording `session`.
pub fn tape(session: u64, ty: &DataType, dates: Dates, what: What) -> (Tape, Reel) {
    let mut scratch = vec![0; HEAD];
    // Reserves what any value of a type of fixed size takes.
    let _ = Record::new(ty).encode_message(&mut scratch);
    let room = if what == What::Times {
        SMALLEST
    } else if ty.is_fixed_size() {
        scratch.len().saturating_mul(SAMPLES).clamp(SMALLEST, GREATEST)
    } else {
        scratch.reserve(4096);
        VARIABLE
    };
    scratch.reserve(Times::BYTES);
    let (writer, reader) = RingBuffer::new(room);
    let lost = Arc::new(AtomicU64::new(0));
    let to = To::Recording { ring: writer, number: 0, lost: Arc::clone(&lost), what };
    let tape = Tape { session, dates, scratch, to };
    (tape, Reel { ring: reader, lost, scratch: Vec::new() })
}

impl Tape {
    /// A tape that keeps the latest values of type `ty` in a black box, as session `session`.
    #[must_use]
    pub fn boxed(session: u64, ty: &DataType, dates: Dates, track: Track) -> Self {
        let mut scratch = vec![0; HEAD];
        let _ = Record::new(ty).encode_message(&mut scratch);
        Self { session, dates, scratch, to: To::BlackBox(track) }
    }

    fn wants_times(&self) -> bool {
        matches!(self.to, To::Recording { what: What::Times, .. })
    }

    fn take(&mut self, value: &Record, way: Way) {
        let moment = self.dates.moment();
        // Whatever the clock of the components.
        let ended = if self.wants_times() { Dates::default().moment() } else { moment };
        self.scratch.clear();
        self.scratch.extend_from_slice(&moment.to_le_bytes());
        self.scratch.extend_from_slice(&[0; 8]);
        let encoded = value.encode_message(&mut self.scratch).is_ok();
        match &mut self.to {
            To::BlackBox(track) if encoded => track.put(moment, &self.scratch[HEAD..]),
            To::BlackBox(track) => track.lose(),
            To::Recording { ring, number, lost, what } => {
                if *what == What::Times {
                    let times = Times {
                        begun: way.begun.unwrap_or(ended),
                        ended,
                        arrived: way.arrived,
                        digest: digest(&self.scratch[HEAD..]),
                    };
                    self.scratch.truncate(HEAD);
                    self.scratch.extend_from_slice(&times.to_bytes());
                }
                let length = u32::try_from(self.scratch.len() - HEAD).unwrap_or(u32::MAX);
                self.scratch[HEAD - 8..HEAD - 4].copy_from_slice(&number.to_le_bytes());
                self.scratch[HEAD - 4..HEAD].copy_from_slice(&length.to_le_bytes());
                *number = number.wrapping_add(1);
                // The sample is pushed as a whole: the reader never sees a part of one.
                if !encoded || ring.push_entire_slice(&self.scratch).is_err() {
                    lost.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
    }
}

fn digest(message: &[u8]) -> u64 {
    let mut hasher = FxHasher::default();
    hasher.write(message);
    hasher.finish()
}

impl Reel {
    /// Passes all available samples to `each`, in order.
    pub fn wind(&mut self, mut each: impl FnMut(Sample<'_>)) {
        let mut left = self.ring.slots();
        let mut head = [0; HEAD];
        while left >= HEAD && self.ring.pop_entire_slice(&mut head).is_ok() {
            let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = head;
            let length = u32::from_le_bytes([m, n, o, p]) as usize;
            self.scratch.resize(length, 0);
            if self.ring.pop_entire_slice(&mut self.scratch).is_err() {
                return;
            }
            left = left.saturating_sub(HEAD + length);
            each(Sample {
                moment: u64::from_le_bytes([a, b, c, d, e, f, g, h]),
                number: u32::from_le_bytes([i, j, k, l]),
                message: &self.scratch,
            });
        }
    }

    /// How many samples were dropped: the ring was full, or they could not be encoded.
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }

    /// Whether the writing end is gone. Check this before the last call of `wind`, so that no
    /// sample is missed.
    pub fn is_over(&self) -> bool {
        self.ring.is_abandoned()
    }
}

/// The tapes that take samples of one port or connection; usually none.
#[derive(Default)]
pub struct Tapes {
    /// Whether there are tapes; spares the codel the lock when there are none.
    any: AtomicBool,
    /// Whether one of them is of times; spares the codel the clock otherwise.
    timed: AtomicBool,
    /// Locked by the codel at each sample, and by the supervisor only while all codels are
    /// excluded.
    all: Mutex<Vec<Tape>>,
}

impl Tapes {
    /// When a write or a read begins, if a tape asks for it.
    #[inline]
    pub fn begin(&self) -> Option<u64> {
        self.timed.load(Ordering::Relaxed).then(|| Dates::default().moment())
    }

    /// Passes a sample to all tapes.
    #[inline]
    pub fn take(&self, value: &Record, way: Way) {
        if self.any.load(Ordering::Relaxed) {
            for tape in self.all.lock().unwrap_or_else(PoisonError::into_inner).iter_mut() {
                tape.take(value, way);
            }
        }
    }

    /// Adds the tape that `make` creates, unless that session has one already.
    pub fn add(&self, session: u64, make: impl FnOnce() -> Tape) {
        let mut all = self.all.lock().unwrap_or_else(PoisonError::into_inner);
        if all.iter().all(|tape| tape.session != session) {
            all.push(make());
            self.note(&all);
        }
    }

    /// Removes the tape of a session.
    pub fn remove(&self, session: u64) {
        let mut all = self.all.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|tape| tape.session != session);
        self.note(&all);
    }

    fn note(&self, all: &[Tape]) {
        self.any.store(!all.is_empty(), Ordering::Relaxed);
        self.timed.store(all.iter().any(Tape::wants_times), Ordering::Relaxed);
    }
}

impl std::fmt::Debug for Tapes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tapes").field("any", &self.any).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use genom_types::{Kind, TypeTable};

    #[test]
    fn what_finds_no_room_is_counted_and_leaves_a_gap_in_the_numbers() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Double);
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let (tape, mut reel) = tape(1, &ty, Dates::default(), What::Contents);
        let tapes = Tapes::default();
        let mut value = Record::new(&ty);
        tapes.take(&value, Way::default());
        tapes.add(1, || tape);
        let room = SMALLEST / (HEAD + 12);
        for number in 0..room + 5 {
            value.merge_json(&(number as f64).into()).unwrap();
            tapes.take(&value, Way::default());
        }
        let mut seen = Vec::new();
        reel.wind(|sample| {
            assert!(sample.moment > 0);
            let mut read = Record::new(&ty);
            read.decode_message(sample.message).unwrap();
            assert_eq!(read.to_json(), f64::from(sample.number));
            seen.push(sample.number);
        });
        assert_eq!((seen.len(), reel.lost()), (room, 5));
        tapes.take(&value, Way::default());
        reel.wind(|sample| seen.push(sample.number));
        assert_eq!(seen.last().copied(), u32::try_from(room + 5).ok());
        tapes.remove(1);
        assert!(reel.is_over());
    }

    #[test]
    fn a_tape_of_times_has_when_and_a_digest_instead_of_the_content() {
        let mut table = TypeTable::default();
        let id = table.add(Kind::Double);
        let ty = DataType::new(&Arc::new(table), id).unwrap();
        let (tape, mut reel) = tape(1, &ty, Dates::default(), What::Times);
        let tapes = Tapes::default();
        assert_eq!(tapes.begin(), None, "nobody asks");
        tapes.add(1, || tape);
        let mut value = Record::new(&ty);
        let begun = tapes.begin();
        assert!(begun.is_some());
        for (number, arrived) in [(1.0, None), (1.0, Some(7)), (2.0, None)] {
            value.merge_json(&f64::into(number)).unwrap();
            tapes.take(&value, Way { begun, arrived });
        }
        let mut seen = Vec::new();
        reel.wind(|sample| seen.push(Times::from_bytes(sample.message).unwrap()));
        let [first, same, other] = seen[..] else { panic!("{seen:?}") };
        assert!(Some(first.begun) == begun && first.ended >= first.begun, "{first:?}");
        assert_eq!((first.arrived, same.arrived), (None, Some(7)));
        assert!(first.digest == same.digest && first.digest != other.digest);
        tapes.remove(1);
        assert_eq!(tapes.begin(), None);
    }
}
