//! Samples in fragments: limits what DDS holds of them until they are complete.

use std::collections::{HashMap, VecDeque};
use std::time::Duration;

use super::answer::Answer;
use super::limits::{ASSEMBLIES, GIVEN_UP, Limits};
use super::message::{Entity, Prefix};
use super::tally::Reason;

/// Identifies a sample: participant, writer, sequence number.
pub(crate) type Sample = (Prefix, Entity, i64);

/// Number of complete samples that are remembered, and for how long. Not longer, because a reader
/// that is created later may want them again.
const COMPLETE: usize = 64;
const TWICE: Duration = Duration::from_millis(500);

/// Content of a DATA_FRAG (8.3.8.3).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Number of its first fragment, from 1.
    pub(crate) first: u32,
    pub(crate) count: u16,
    /// Size of a fragment in bytes.
    pub(crate) fragment: u16,
    /// Size of the whole sample in bytes.
    pub(crate) whole: u32,
    /// Size of its payload in bytes.
    pub(crate) payload: usize,
}

#[derive(Debug)]
struct Assembly {
    whole: u32,
    fragment: u16,
    left: u32,
    came: Vec<u64>,
    seen: Duration,
}

#[derive(Debug)]
pub(crate) struct Pieces {
    assemblies: HashMap<Sample, Assembly>,
    bytes: u64,
    limits: Limits,
    /// The last samples that were complete, and since when.
    complete: VecDeque<(Sample, Duration)>,
}

impl Pieces {
    pub(crate) fn new(limits: &Limits) -> Self {
        let (assemblies, complete) = (HashMap::new(), VecDeque::new());
        Self { assemblies, bytes: 0, limits: *limits, complete }
    }

    /// Checks whether DDS may receive a fragment. Those of a sample that has just become complete
    /// are dropped: for a fragment that arrives twice RustDDS would begin to assemble the sample
    /// again, and hold it.
    pub(crate) fn add(
        &mut self,
        sample: Sample,
        piece: Piece,
        now: Duration,
    ) -> Result<Answer, Reason> {
        let Piece { first, count, fragment, whole, payload } = piece;
        // 8.3.8.3.3: validity.
        if fragment == 0 || u32::from(fragment) > whole || first == 0 || count == 0 {
            return Err(Reason::Malformed);
        }
        let total = whole.div_ceil(u32::from(fragment));
        if whole > self.limits.sample || total > self.limits.fragments() {
            return Err(Reason::Sample);
        }
        let end = first.checked_add(u32::from(count)).ok_or(Reason::Malformed)?;
        if end - 1 > total || payload > usize::from(count) * usize::from(fragment) {
            return Err(Reason::Malformed);
        }
        if count == 1 && total == 1 {
            return Ok(Answer::Pass);
        }
        let just =
            |(of, since): &(Sample, Duration)| *of == sample && now.saturating_sub(*since) < TWICE;
        if self.complete.iter().any(just) {
            return Ok(Answer::Drop);
        }
        if !self.assemblies.contains_key(&sample) {
            self.make_room(&sample, whole, now)?;
            let came = vec![0; total.div_ceil(64) as usize];
            let assembly = Assembly { whole, fragment, left: total, came, seen: now };
            self.assemblies.insert(sample, assembly);
            self.bytes += u64::from(whole);
        }
        let Some(assembly) = self.assemblies.get_mut(&sample) else {
            return Ok(Answer::Pass);
        };
        if (assembly.whole, assembly.fragment) != (whole, fragment) {
            return Err(Reason::Malformed);
        }
        assembly.seen = now;
        for number in first - 1..end - 1 {
            let bit = 1 << (number % 64);
            if let Some(word) = assembly.came.get_mut(number as usize / 64)
                && *word & bit == 0
            {
                *word |= bit;
                assembly.left -= 1;
            }
        }
        if assembly.left == 0 {
            self.bytes -= u64::from(whole);
            self.assemblies.remove(&sample);
            self.complete.truncate(COMPLETE - 1);
            self.complete.push_front((sample, now));
        }
        Ok(Answer::Pass)
    }

    /// Makes room for another sample by forgetting those that DDS has given up by now.
    fn make_room(&mut self, sample: &Sample, whole: u32, now: Duration) -> Result<(), Reason> {
        let bytes = &mut self.bytes;
        self.assemblies.retain(|(prefix, entity, _), assembly| {
            let same = (*prefix, *entity) == (sample.0, sample.1);
            let most = if same { GIVEN_UP.0 } else { GIVEN_UP.1 };
            let stays = now.saturating_sub(assembly.seen) < most;
            if !stays {
                *bytes -= u64::from(assembly.whole);
            }
            stays
        });
        let theirs = self.assemblies.iter().filter(|((prefix, ..), _)| *prefix == sample.0);
        let theirs: u64 = theirs.map(|(_, assembly)| u64::from(assembly.whole)).sum();
        let (whole, most) = (u64::from(whole), self.limits.assembly());
        let full = self.assemblies.len() >= ASSEMBLIES || self.bytes + whole > most;
        if full || theirs + whole > most / 2 { Err(Reason::Assembly) } else { Ok(()) }
    }

    /// Whether this is a valid number of a fragment to request.
    pub(crate) fn can_ask(&self, fragment: u32) -> bool {
        (1..=self.limits.fragments()).contains(&fragment)
    }

    /// Forgets the samples of a participant that is gone.
    pub(crate) fn forget(&mut self, participant: &Prefix) {
        self.complete.retain(|((prefix, ..), _)| prefix != participant);
        let bytes = &mut self.bytes;
        self.assemblies.retain(|(prefix, ..), assembly| {
            let stays = prefix != participant;
            if !stays {
                *bytes -= u64::from(assembly.whole);
            }
            stays
        });
    }
}
