//! The reading side: what is in the memory of a process, whether it lives or not.
//!
//! The memory is copied with `pread`, headers of blocks before and after: a block that changed
//! hands meanwhile is left out. So are blocks that no track has, most of a memory that was never
//! full. Nothing is believed: a codel may have written anywhere, and a process may have been killed
//! anywhere.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;
use std::ops::Range;
use std::os::unix::fs::FileExt as _;

use crate::layout::{
    BLOCK, BUSY, CURRENT, ENTRY, FIRST, FREE, HEAD_AT, HEAD_LENGTH, HEADER, HEADS, LONGEST_HEAD,
    MARK, NONE, OPEN, OWNER, RECORD, REFUSED, SEQUENCE, STATE, TAKEN, USED, halves, padded,
};
use crate::memory::Memory;

/// What is kept of a track.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kept {
    /// What it is of, in the words of who made it.
    pub head: Vec<u8>,
    /// Whether it still takes records, or did when the process ended.
    pub open: bool,
    /// Records that it took, and how many of these it refused.
    pub taken: u64,
    /// As above.
    pub refused: u64,
    bytes: Vec<u8>,
    records: Vec<(u64, u64, Range<usize>)>,
}

/// A record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record<'a> {
    /// When it was taken, as its writer said.
    pub moment: u64,
    /// Its number in the track, from 0.
    pub number: u64,
    /// What was written.
    pub content: &'a [u8],
}

/// How full a memory is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Filled {
    /// Tracks that take records.
    pub tracks: u64,
    /// Bytes of records.
    pub bytes: u64,
    /// Records taken, and refused, by these tracks.
    pub taken: u64,
    /// As above.
    pub refused: u64,
}

impl Kept {
    /// The records, the oldest first.
    pub fn records(&self) -> impl ExactSizeIterator<Item = Record<'_>> {
        self.records.iter().map(|(moment, number, content)| Record {
            moment: *moment,
            number: *number,
            content: self.bytes.get(content.clone()).unwrap_or_default(),
        })
    }

    /// How many records were taken before the first of those that are kept.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.records.first().map_or(self.taken, |(_, number, _)| *number)
    }
}

/// A part of the memory, as words.
struct Words(Vec<u8>);

impl Words {
    fn read(file: &File, part: Range<usize>) -> io::Result<Self> {
        let mut bytes = vec![0; part.len()];
        file.read_exact_at(&mut bytes, part.start as u64)?;
        Ok(Self(bytes))
    }

    fn get(&self, at: usize) -> u64 {
        let word = self.0.get(at..).and_then(<[u8]>::first_chunk);
        word.map_or(0, |word| u64::from_le_bytes(*word))
    }
}

/// Blocks that tracks have.
struct Pool {
    /// The number of each block, rising.
    blocks: Vec<usize>,
    /// Neighbours that were read at once, each with the number of its first block, rising.
    runs: Vec<(usize, Words)>,
}

impl Pool {
    /// Reads the blocks that have an owner, according to these headers.
    fn read(memory: &Memory, headers: &Words) -> io::Result<Self> {
        let Memory { file, layout } = memory;
        let owned = |block: &usize| {
            let (owner, _) = halves(headers.get(block * HEADER + OWNER));
            owner != 0 && owner != BUSY
        };
        let blocks: Vec<usize> = (0..layout.blocks).filter(owned).collect();
        let mut runs = Vec::new();
        for run in blocks.chunk_by(|one, next| one + 1 == *next) {
            let [first, ..] = run else { continue };
            let part = layout.block(*first)..layout.block(first + run.len());
            runs.push((*first, Words::read(file, part)?));
        }
        Ok(Self { blocks, runs })
    }

    /// The first bytes of a block.
    fn get(&self, block: usize, used: usize) -> Option<&[u8]> {
        let run = self.runs.partition_point(|(first, _)| *first <= block).checked_sub(1)?;
        let (first, Words(bytes)) = self.runs.get(run)?;
        let from = (block - first) * BLOCK;
        bytes.get(from..from + used)
    }
}

/// How full a memory is.
///
/// # Errors
/// It cannot be read.
pub fn filled(memory: &Memory) -> io::Result<Filled> {
    let Memory { file, layout } = memory;
    let entries = Words::read(file, layout.entry(0)..layout.entry(layout.blocks))?;
    let headers = Words::read(file, layout.header(0)..layout.heads())?;
    let mut told = Filled::default();
    for entry in 0..layout.blocks {
        let at = |word: usize| entries.get(entry * ENTRY + word);
        if halves(at(STATE)).0 == OPEN {
            told.tracks += 1;
            told.taken = told.taken.saturating_add(at(TAKEN));
            told.refused = told.refused.saturating_add(at(REFUSED));
        }
    }
    let used = |block| headers.get(block * HEADER + USED).min(BLOCK as u64);
    told.bytes = (0..layout.blocks).map(used).sum();
    Ok(told)
}

/// All that is kept, of every track.
///
/// # Errors
/// It cannot be read.
pub fn read(memory: &Memory) -> io::Result<Vec<Kept>> {
    let Memory { file, layout } = memory;
    let blocks = layout.blocks;
    let entries = Words::read(file, layout.entry(0)..layout.entry(blocks))?;
    let before = Words::read(file, layout.header(0)..layout.heads())?;
    let pool = Pool::read(memory, &before)?;
    let after = Words::read(file, layout.header(0)..layout.heads())?;
    // Blocks of each entry, by their place in its stream.
    let mut owned: BTreeMap<usize, BTreeMap<u64, usize>> = BTreeMap::new();
    for block in pool.blocks.iter().copied() {
        let at = |words: &Words, word| words.get(block * HEADER + word);
        let hands = |words| at(words, OWNER) & !CURRENT;
        let (owner, _) = halves(at(&before, OWNER));
        let same = hands(&before) == hands(&after) && at(&before, SEQUENCE) == at(&after, SEQUENCE);
        let Some(entry) = (owner as usize).checked_sub(1).filter(|_| same) else {
            continue;
        };
        let state = entries.get(entry.saturating_mul(ENTRY) + STATE);
        let is_of = halves(state).1 == halves(at(&before, FIRST)).1 && halves(state).0 != FREE;
        if entry < blocks && is_of {
            owned.entry(entry).or_default().insert(at(&before, SEQUENCE), block);
        }
    }
    let mut kept = Vec::new();
    // Together, heads are as long as the part that holds them.
    let mut heads = HEADS;
    for entry in 0..blocks {
        let at = |word: usize| entries.get(entry * ENTRY + word);
        let (state, _) = halves(at(STATE));
        if state == FREE {
            continue;
        }
        let (from, length) = (at(HEAD_AT), at(HEAD_LENGTH));
        let (Ok(from), Ok(length)) = (usize::try_from(from), usize::try_from(length)) else {
            continue;
        };
        let within = from < HEADS && length <= LONGEST_HEAD.min(heads).min(HEADS - from);
        if !within {
            continue;
        }
        heads -= length;
        let from = layout.heads() + from;
        let Words(head) = Words::read(file, from..from + length)?;
        let mut one = Kept {
            head,
            open: state == OPEN,
            taken: at(TAKEN),
            refused: at(REFUSED),
            bytes: Vec::new(),
            records: Vec::new(),
        };
        if let Some(own) = owned.get(&entry) {
            one.gather(own, &before, &pool);
        }
        kept.push(one);
    }
    Ok(kept)
}

impl Kept {
    /// Puts the stream together, and finds its records.
    fn gather(&mut self, own: &BTreeMap<u64, usize>, headers: &Words, pool: &Pool) {
        let mut begin = 0;
        let mut next = None;
        for (sequence, block) in own {
            let at = |word: usize| headers.get(block * HEADER + word);
            let used = usize::try_from(at(USED)).unwrap_or(usize::MAX).min(BLOCK);
            let data = pool.get(*block, used).unwrap_or_default();
            if next != Some(*sequence) {
                // A record that began in a block that is gone.
                self.parse(begin);
                begin = self.bytes.len();
                let (first, _) = halves(at(FIRST));
                let from = data.get(first as usize..).filter(|_| first != NONE);
                let Some(from) = from else { continue };
                self.bytes.extend_from_slice(from);
            } else {
                self.bytes.extend_from_slice(data);
            }
            // Only the last one is not full.
            next = (used == BLOCK).then(|| sequence.wrapping_add(1));
        }
        self.parse(begin);
    }

    /// Finds the records in what was put together from here on.
    fn parse(&mut self, mut at: usize) {
        while let Some(head) = self.bytes.get(at..).and_then(<[u8]>::first_chunk::<RECORD>) {
            let word = |at: usize| {
                let bytes = head.get(at..).and_then(<[u8]>::first_chunk);
                bytes.map_or(0, |bytes| u64::from_le_bytes(*bytes))
            };
            let ((mark, length), moment, number) = (halves(word(0)), word(8), word(16));
            let begin = at + RECORD;
            let end = begin.saturating_add(length as usize);
            let rises = self.records.last().is_none_or(|(_, before, _)| *before < number);
            if mark != MARK ^ halves(number).0 || end > self.bytes.len() || !rises {
                return;
            }
            self.records.push((moment, number, begin..end));
            at = begin + padded(length as usize);
        }
    }
}

#[cfg(test)]
mod tests;
