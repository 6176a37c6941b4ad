//! What is where in the memory. All numbers are little endian, and at multiples of their size.
//!
//! | Part | Content |
//! |---|---|
//! | start, 4096 bytes | [`MAGIC`], number of blocks |
//! | entries, 64 bytes each, one per block | of a track: state, generation, where its head is, how many records it took and refused |
//! | headers, 32 bytes each, one per block | owner, place in the owner's stream, bytes used, where the first record begins |
//! | heads, 4 MiB | what each track is of, in the words of who made it |
//! | blocks, 2 KiB each | pieces of streams |
//!
//! The stream of a track is a sequence of records, each a head of 24 bytes (mark, length, moment,
//! number) and its content, padded to 8 bytes. A record may begin in one block and end in another.
//! The file is sparse: what was never written takes no memory.

/// First word of the memory.
pub(crate) const MAGIC: u64 = u64::from_le_bytes(*b"genombb1");

/// Bytes of a block.
pub(crate) const BLOCK: usize = 2048;

/// Bytes of the start.
pub(crate) const START: usize = 4096;
/// Bytes of an entry, of a block's header, and of the head of a record.
pub(crate) const ENTRY: usize = 64;
pub(crate) const HEADER: usize = 32;
pub(crate) const RECORD: usize = 24;

/// Bytes for heads of tracks, of which most take some hundred.
pub(crate) const HEADS: usize = 4 << 20;
/// Longest head of a track.
pub(crate) const LONGEST_HEAD: usize = 64 << 10;

/// Words of an entry.
pub(crate) const STATE: usize = 0;
pub(crate) const HEAD_AT: usize = 8;
pub(crate) const HEAD_LENGTH: usize = 16;
pub(crate) const TAKEN: usize = 24;
pub(crate) const REFUSED: usize = 32;

/// States of an entry, in the low half of its first word; the generation is in the high half.
pub(crate) const FREE: u32 = 0;
pub(crate) const OPEN: u32 = 1;
pub(crate) const CLOSED: u32 = 2;

/// Words of a block's header.
pub(crate) const OWNER: usize = 0;
pub(crate) const SEQUENCE: usize = 8;
pub(crate) const USED: usize = 16;
/// Where the first record begins in the low half, generation of the owner in the high half.
pub(crate) const FIRST: usize = 24;

/// Value of the low half of [`FIRST`] where no record begins in the block.
pub(crate) const NONE: u32 = u32::MAX;

/// In the word [`OWNER`]: a track writes to the block. The low half is the track's entry plus one,
/// or [`BUSY`]; what is between counts how often the block was taken.
pub(crate) const CURRENT: u64 = 1 << 63;
/// The block is changing hands.
pub(crate) const BUSY: u32 = u32::MAX;

/// Mark of a record, before its number is mixed in.
pub(crate) const MARK: u32 = 0x6b6f_6f4c;

/// Least and most bytes of blocks.
pub const LEAST_BYTES: u64 = 256 << 10;
/// As above.
pub const MOST_BYTES: u64 = 1 << 30;

/// Where the parts are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    pub(crate) blocks: usize,
}

impl Layout {
    /// Of a memory with this many bytes of blocks; within the limits.
    pub(crate) fn of_bytes(bytes: u64) -> Self {
        let bytes = bytes.clamp(LEAST_BYTES, MOST_BYTES);
        Self { blocks: usize::try_from(bytes).unwrap_or(usize::MAX) / BLOCK }
    }

    /// Of a memory of this size; `None` if there is none such.
    pub(crate) fn of_size(size: u64) -> Option<Self> {
        let size = usize::try_from(size).ok()?;
        let rest = size.checked_sub(START + HEADS)?;
        let each = ENTRY + HEADER + BLOCK;
        let found = Self { blocks: rest / each };
        let bytes = (found.blocks * BLOCK) as u64;
        let fits = rest % each == 0 && (LEAST_BYTES..=MOST_BYTES).contains(&bytes);
        fits.then_some(found)
    }

    pub(crate) fn entry(self, index: usize) -> usize {
        START + index * ENTRY
    }

    pub(crate) fn header(self, index: usize) -> usize {
        self.entry(self.blocks) + index * HEADER
    }

    pub(crate) fn heads(self) -> usize {
        self.header(self.blocks)
    }

    pub(crate) fn block(self, index: usize) -> usize {
        self.heads() + HEADS + index * BLOCK
    }

    pub(crate) fn size(self) -> usize {
        self.block(self.blocks)
    }
}

/// A record's content is padded to this.
pub(crate) fn padded(length: usize) -> usize {
    length.next_multiple_of(8)
}

/// Low and high half of a word.
pub(crate) fn halves(word: u64) -> (u32, u32) {
    ((word & u64::from(u32::MAX)) as u32, (word >> 32) as u32)
}

/// A word of two halves.
pub(crate) fn word(low: u32, high: u32) -> u64 {
    u64::from(low) | u64::from(high) << 32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_of_a_memory_says_how_many_blocks_it_has() {
        for bytes in [0, LEAST_BYTES, 3 << 20, 8 << 20, MOST_BYTES, u64::MAX] {
            let layout = Layout::of_bytes(bytes);
            assert_eq!(Layout::of_size(layout.size() as u64), Some(layout));
            assert_eq!(Layout::of_size(layout.size() as u64 + 8), None);
        }
        assert_eq!((Layout::of_size(0), Layout::of_size(u64::MAX)), (None, None));
    }
}
