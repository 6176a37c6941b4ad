//! Sizes, alignments and offsets as the C compiler computes them (genom3.md 5.2).
//!
//! A layout is computed from those of the members; `graph` walks the types.

use thiserror::Error;

/// Largest value that is laid out, in bytes; also the greatest number of elements of size 0 that a
/// value may contain.
pub const MAX_SIZE: usize = 1 << 30;

/// Deepest nesting of types by value.
pub const MAX_NESTING: usize = 128;

/// Size, alignment and offsets of members of a type, in bytes, as gcc computes them on x86-64 and
/// aarch64.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Layout {
    /// `sizeof`; 0 for a record without members and for an array of such records.
    pub size: usize,
    /// `_Alignof`.
    pub align: usize,
    /// Struct, exception: offset of each member. Union: of `_u`. Optional: of `_value`.
    /// Unbounded sequence: of `_maximum`, `_length`, `_buffer`, `_release`. Bounded sequence: of
    /// `_maximum`, `_length`, `_buffer`. Empty for others.
    pub offsets: Vec<usize>,
    /// No pointer inside (unbounded string or sequence, native): the value can be copied byte by
    /// byte.
    pub fixed: bool,
}

/// Why a type has no layout.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum LayoutError {
    /// `any` parses but has no mapping.
    #[error("type any has no C mapping; give the type a definite content")]
    Any,
    /// A forward declaration that was never completed.
    #[error("{name} is only announced, never defined; add its definition")]
    Incomplete {
        /// Full name of the announced type.
        name: String,
    },
    /// An exception without members is no data type.
    #[error("exception {name} has no members, so it is no data type; use it in `throw` only")]
    Void {
        /// Full name of the exception.
        name: String,
    },
    /// A type that contains itself by value.
    #[error("{name} contains itself; use an unbounded sequence for the inner one")]
    Recursive {
        /// Full name of the type.
        name: String,
    },
    /// Larger than [`MAX_SIZE`].
    #[error("{name} takes more than {MAX_SIZE} bytes; use smaller bounds or unbounded sequences")]
    TooLarge {
        /// Spelling of the type.
        name: String,
    },
    /// Nested deeper than [`MAX_NESTING`].
    #[error("{name} is nested more than {MAX_NESTING} types deep; flatten it")]
    TooDeep {
        /// Spelling of the type.
        name: String,
    },
    /// A sequence whose elements have size 0: the shortest message could announce any length.
    #[error("{name} is a sequence of elements without size; give the element a member")]
    EmptyElement {
        /// Spelling of the type.
        name: String,
    },
    /// A union whose discriminant is not a boolean, char, integer or enum.
    #[error("union {name} is switched by {found}; use a boolean, char, integer or enum type")]
    Discriminant {
        /// Full name of the union.
        name: String,
        /// Spelling of the discriminant's type.
        found: String,
    },
}

impl Layout {
    /// A type without inner structure.
    pub(crate) fn scalar(size: usize) -> Self {
        Self { size, align: size, offsets: Vec::new(), fixed: true }
    }

    /// A pointer to memory outside the value.
    pub(crate) fn pointer() -> Self {
        Self { fixed: false, ..Self::scalar(8) }
    }

    /// `char[n]`.
    pub(crate) fn text(bound: usize) -> Option<Self> {
        Some(Self { size: limited(bound)?, ..Self::scalar(1) })
    }

    /// Members one after the other; `None` when the sum is too large.
    pub(crate) fn sequential<'a>(members: impl IntoIterator<Item = &'a Layout>) -> Option<Self> {
        let mut whole = Self { size: 0, align: 1, offsets: Vec::new(), fixed: true };
        for member in members {
            let offset = whole.size.next_multiple_of(member.align);
            whole.offsets.push(offset);
            whole.size = limited(offset + member.size)?;
            whole.align = whole.align.max(member.align);
            whole.fixed &= member.fixed;
        }
        whole.size = limited(whole.size.next_multiple_of(whole.align))?;
        Some(whole)
    }

    /// Members all at offset 0, as in a C union.
    pub(crate) fn overlaid<'a>(members: impl IntoIterator<Item = &'a Layout>) -> Self {
        let mut whole = Self { size: 0, align: 1, offsets: Vec::new(), fixed: true };
        for member in members {
            whole.size = whole.size.max(member.size);
            whole.align = whole.align.max(member.align);
            whole.fixed &= member.fixed;
        }
        whole.size = whole.size.next_multiple_of(whole.align);
        whole
    }

    /// `T x[n]`.
    pub(crate) fn array(element: &Layout, length: usize) -> Option<Self> {
        Some(Self {
            size: limited(element.size.checked_mul(length)?)?,
            align: element.align,
            offsets: Vec::new(),
            fixed: element.fixed,
        })
    }

    /// `struct { uint32_t _maximum, _length; T *_buffer; void (*_release)(void *); }`
    pub(crate) fn unbounded_sequence() -> Self {
        Self { size: 24, align: 8, offsets: vec![0, 4, 8, 16], fixed: false }
    }

    /// `struct { const uint32_t _maximum; uint32_t _length; T _buffer[n]; }`
    pub(crate) fn bounded_sequence(element: &Layout, bound: usize) -> Option<Self> {
        let word = Self::scalar(4);
        Self::sequential([&word, &word, &Self::array(element, bound)?])
    }
}

/// `size`, unless it exceeds [`MAX_SIZE`].
fn limited(size: usize) -> Option<usize> {
    (size <= MAX_SIZE).then_some(size)
}
