//! Memory that searches take. What is counted is at least what is allocated, so that a limit of memory
//! is one: each element is counted as in a list that has just doubled.

/// What an allocator may add to each piece of memory.
pub const PIECE: usize = 16;

/// Of an entry of an `IndexSet` of bytes, beside the bytes: in its list a hash and where the bytes
/// are, and in its table, which is filled by 7/16 at least, a number and a mark.
pub const ENTRY: usize = listed::<(u64, Box<[u8]>)>() + (8 + 1) * 16 / 7 + 1 + PIECE;

/// Of an element of a list that grows.
#[must_use]
pub const fn listed<T>() -> usize {
    2 * size_of::<T>()
}
