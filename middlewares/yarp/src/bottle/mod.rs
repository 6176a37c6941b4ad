//! Bottles, YARP's portable encoding: lists of values that name their kind, without a type.
//!
//! `encode` and `decode` translate between samples in CDR and bottles, led by the type; [`Value`]
//! is a bottle as a tree, for short ones: administration and text.

mod cdr;
pub(crate) mod decode;
pub(crate) mod encode;
pub(crate) mod reader;
pub(crate) mod skim;
pub(crate) mod text;
mod value;

pub(crate) use value::Value;

/// Tags of values. All numbers are little endian.
pub(crate) mod tag {
    pub(crate) const INT32: u32 = 1;
    pub(crate) const INT64: u32 = 1 + 16;
    pub(crate) const INT8: u32 = 32;
    pub(crate) const INT16: u32 = 64;
    pub(crate) const FLOAT32: u32 = 128;
    pub(crate) const FLOAT64: u32 = 2 + 8;
    pub(crate) const STRING: u32 = 4;
    pub(crate) const VOCAB: u32 = 1 + 8;
    pub(crate) const BLOB: u32 = 4 + 8;
    /// Added to the tag that all elements share, or alone where each has its own.
    pub(crate) const LIST: u32 = 256;
}

/// Greatest depth of lists within lists.
pub(crate) const MOST_DEPTH: usize = 64;

/// Bytes of a value of this tag; `None` if that depends on the value, or there is no such tag.
pub(crate) fn width(tag: u32) -> Option<usize> {
    match tag {
        tag::INT8 => Some(1),
        tag::INT16 => Some(2),
        tag::INT32 | tag::VOCAB | tag::FLOAT32 => Some(4),
        tag::INT64 | tag::FLOAT64 => Some(8),
        _ => None,
    }
}

/// The bytes are no bottle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NoBottle {
    #[error("it is cut")]
    Cut,
    #[error("it has a value of the unknown kind {0}")]
    Tag(u32),
    #[error("it has a negative length")]
    Negative,
    #[error("it has lists within lists, {MOST_DEPTH} deep")]
    Deep,
    #[error("there is something after its end")]
    Long,
}
