//! The writing side: tracks, which take records without waiting, allocating or calling the system.

use std::collections::VecDeque;
use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::layout::{
    BLOCK, BUSY, CLOSED, CURRENT, FIRST, FREE, HEAD_AT, HEAD_LENGTH, Layout, MARK, NONE, OPEN,
    OWNER, RECORD, REFUSED, SEQUENCE, STATE, TAKEN, USED, halves, padded, word,
};
use crate::map::Map;
use crate::memory::Memory;
use crate::plan::{Entry, Full, Plan};

/// Writes to a memory; the one process that maps it has one.
#[derive(Clone, Debug)]
pub struct Writer(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    map: Map,
    layout: Layout,
    /// The block that is asked for next.
    next: AtomicUsize,
    /// Locked where tracks begin and end, not where they write.
    plan: Mutex<Plan>,
}

/// There is no room for a track.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoRoom {
    /// Each track has a block at least, and as many go round.
    #[error("it has room for {0} tracks")]
    Tracks(usize),
    /// Descriptions of what they record have a limit together.
    #[error("the descriptions of its tracks take 4 MiB, or this one more than 64 KiB")]
    Heads,
}

impl Shared {
    fn plan(&self) -> MutexGuard<'_, Plan> {
        self.plan.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes a block from whoever has it, but not one that is being written to.
    fn seize(&self, block: usize, seen: u64) -> bool {
        let (owner, taken) = halves(seen);
        if seen & CURRENT != 0 || owner == BUSY {
            return false;
        }
        let busy = word(BUSY, (taken + 1) & 0x7fff_ffff);
        let header = self.map.word(self.layout.header(block) + OWNER);
        header.compare_exchange(seen, busy, Ordering::AcqRel, Ordering::Relaxed).is_ok()
    }

    fn owner(&self, block: usize) -> u64 {
        self.map.word(self.layout.header(block) + OWNER).load(Ordering::Acquire)
    }

    /// The oldest block of all.
    fn oldest(&self) -> Option<usize> {
        let blocks = self.layout.blocks;
        (0..blocks).find_map(|_| {
            let block = self.next.fetch_add(1, Ordering::Relaxed) % blocks;
            self.seize(block, self.owner(block)).then_some(block)
        })
    }
}

impl Writer {
    /// Maps a memory, which nobody has written to.
    ///
    /// # Errors
    /// The system refuses.
    pub fn new(memory: &Memory) -> io::Result<Self> {
        let layout = memory.layout;
        let map = Map::new(memory, layout.size())?;
        let plan = Mutex::new(Plan::new(layout.blocks));
        Ok(Self(Arc::new(Shared { map, layout, next: AtomicUsize::new(0), plan })))
    }

    /// A track of what `head` says, which holds `most` bytes at most.
    ///
    /// # Errors
    /// There is no room.
    pub fn track(&self, head: &[u8], most: usize) -> Result<Track, NoRoom> {
        let Shared { map, layout, .. } = &*self.0;
        let mut plan = self.0.plan();
        let state = |index: usize| map.word(layout.entry(index) + STATE);
        let generation = |index| halves(state(index).load(Ordering::Relaxed)).1;
        let removed = |index| state(index).store(word(FREE, generation(index)), Ordering::Release);
        let entry = plan.take(head.len(), removed).map_err(|full| match full {
            Full::Entries => NoRoom::Tracks(layout.blocks / 2),
            Full::Heads => NoRoom::Heads,
        })?;
        let generation = generation(entry.index).wrapping_add(1);
        map.write(layout.heads() + entry.at, head);
        for (at, value) in
            [(HEAD_AT, entry.at), (HEAD_LENGTH, head.len()), (TAKEN, 0), (REFUSED, 0)]
        {
            map.word(layout.entry(entry.index) + at).store(value as u64, Ordering::Relaxed);
        }
        state(entry.index).store(word(OPEN, generation), Ordering::Release);
        let most = (most / BLOCK).clamp(2, layout.blocks / 4);
        Ok(Track {
            shared: Arc::clone(&self.0),
            entry,
            generation,
            block: None,
            used: 0,
            sequence: 0,
            own: VecDeque::with_capacity(most),
            most,
            taken: 0,
            refused: 0,
        })
    }
}

/// Takes the records of one port or subject, one thread at a time.
#[derive(Debug)]
pub struct Track {
    shared: Arc<Shared>,
    entry: Entry,
    generation: u32,
    /// The block that is written to, and its bytes used.
    block: Option<usize>,
    used: usize,
    /// Place of the next block in the stream.
    sequence: u64,
    /// Blocks that it had before, the oldest first; others may have taken them since.
    own: VecDeque<u32>,
    most: usize,
    taken: u64,
    refused: u64,
}

impl Track {
    /// Takes a record; one that is larger than the track, less a block, is refused and counted.
    #[inline]
    pub fn put(&mut self, moment: u64, content: &[u8]) {
        let number = self.taken;
        self.taken += 1;
        self.count(TAKEN, self.taken);
        let whole = RECORD + padded(content.len());
        let length = u32::try_from(content.len()).unwrap_or(u32::MAX);
        if whole > (self.most - 1) * BLOCK || self.write(moment, number, length, content).is_none()
        {
            self.refuse();
        }
    }

    /// Counts a record that could not be made.
    pub fn lose(&mut self) {
        self.taken += 1;
        self.count(TAKEN, self.taken);
        self.refuse();
    }

    fn refuse(&mut self) {
        self.refused += 1;
        self.count(REFUSED, self.refused);
    }

    fn count(&self, at: usize, value: u64) {
        let Shared { map, layout, .. } = &*self.shared;
        map.word(layout.entry(self.entry.index) + at).store(value, Ordering::Relaxed);
    }

    fn write(&mut self, moment: u64, number: u64, length: u32, content: &[u8]) -> Option<()> {
        let mark = MARK ^ halves(number).0;
        let mut head = [0; RECORD];
        head[..8].copy_from_slice(&word(mark, length).to_le_bytes());
        head[8..16].copy_from_slice(&moment.to_le_bytes());
        head[16..].copy_from_slice(&number.to_le_bytes());
        self.room()?;
        self.begin();
        self.append(&head)?;
        self.append(content)?;
        self.append(&[0; 8][..padded(content.len()) - content.len()])?;
        // What is before is there for readers from here on.
        self.publish();
        Some(())
    }

    /// Appends to the stream, over as many blocks as it takes.
    fn append(&mut self, mut bytes: &[u8]) -> Option<()> {
        while !bytes.is_empty() {
            let block = self.room()?;
            let (now, rest) = bytes.split_at(bytes.len().min(BLOCK - self.used));
            let Shared { map, layout, .. } = &*self.shared;
            map.write(layout.block(block) + self.used, now);
            self.used += now.len();
            bytes = rest;
        }
        Some(())
    }

    /// A record begins here.
    fn begin(&self) {
        let Some(block) = self.block else { return };
        let Shared { map, layout, .. } = &*self.shared;
        let first = map.word(layout.header(block) + FIRST);
        if halves(first.load(Ordering::Relaxed)).0 == NONE {
            let used = u32::try_from(self.used).unwrap_or(NONE);
            first.store(word(used, self.generation), Ordering::Relaxed);
        }
    }

    fn publish(&self) {
        let Some(block) = self.block else { return };
        let Shared { map, layout, .. } = &*self.shared;
        map.word(layout.header(block) + USED).store(self.used as u64, Ordering::Release);
    }

    /// A block with room; the next one if that is full.
    #[inline]
    fn room(&mut self) -> Option<usize> {
        match self.block {
            Some(block) if self.used < BLOCK => Some(block),
            _ => self.next(),
        }
    }

    fn next(&mut self) -> Option<usize> {
        self.leave();
        let Some(block) = self.own_oldest().or_else(|| self.shared.oldest()) else {
            // What was begun does not go on: readers see a gap.
            self.sequence += 1;
            return None;
        };
        let Shared { map, layout, .. } = &*self.shared;
        let header = |at: usize| map.word(layout.header(block) + at);
        header(SEQUENCE).store(self.sequence, Ordering::Relaxed);
        header(USED).store(0, Ordering::Relaxed);
        header(FIRST).store(word(NONE, self.generation), Ordering::Relaxed);
        let (_, taken) = halves(header(OWNER).load(Ordering::Relaxed));
        let entry = u32::try_from(self.entry.index).unwrap_or(BUSY - 1) + 1;
        header(OWNER).store(word(entry, taken) | CURRENT, Ordering::Release);
        self.sequence += 1;
        (self.block, self.used) = (Some(block), 0);
        Some(block)
    }

    /// The oldest block of this track, when it holds its share.
    fn own_oldest(&mut self) -> Option<usize> {
        let entry = u32::try_from(self.entry.index).unwrap_or(BUSY - 1) + 1;
        while self.own.len() >= self.most - 1 {
            let block = self.own.pop_front()? as usize;
            let seen = self.shared.owner(block);
            if halves(seen).0 == entry && self.shared.seize(block, seen) {
                return Some(block);
            }
        }
        None
    }

    /// Lets others have the block, once its turn comes.
    fn leave(&mut self) {
        let Some(block) = self.block.take() else { return };
        let Shared { map, layout, .. } = &*self.shared;
        map.word(layout.header(block) + USED).store(self.used as u64, Ordering::Release);
        map.word(layout.header(block) + OWNER).fetch_and(!CURRENT, Ordering::Release);
        // There is room: as much was asked for as the track may hold.
        self.own.push_back(u32::try_from(block).unwrap_or(u32::MAX));
    }
}

impl Drop for Track {
    fn drop(&mut self) {
        self.leave();
        let Shared { map, layout, .. } = &*self.shared;
        let state = map.word(layout.entry(self.entry.index) + STATE);
        state.store(word(CLOSED, self.generation), Ordering::Release);
        self.shared.plan().close(self.entry);
    }
}
