//! IDL values as CDR (XCDR1, PLAIN_CDR), from and to C layout through a compiled plan.
//!
//! | IDL | CDR |
//! |---|---|
//! | boolean, octet, char | 1 byte |
//! | integers, float, double | as is, aligned to their size from the start of the payload |
//! | enum | 4 bytes, in range |
//! | string, `string<n>` | length with NUL, UTF-8 bytes, NUL; a bounded one has at most n - 1 bytes |
//! | array | elements, dimensions row by row |
//! | sequence | length, elements |
//! | optional | a sequence of 0 or 1 |
//! | struct | its members |
//! | union | discriminant, then each member as a sequence: of 1 the selected one, of 0 the others |
//! | native | refused |
//!
//! Written little endian; read in both byte orders. Bytes after the value are ignored: DDS pads
//! messages.

mod check;
mod decode;
mod encode;
mod error;
pub(crate) mod plan;
mod reader;
mod size;
pub(crate) mod step;

pub(crate) use decode::decode;
pub use encode::SLACK;
pub(crate) use encode::{encode, encode_into};
pub use error::{CdrError, CdrProblem};
pub(crate) use size::size;

use self::plan::plan;
use self::step::{Step, What};
use crate::data_type::DataType;

/// The encapsulation header before a payload as we write it: plain CDR, little endian.
pub const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Size of every payload of a type all of whose bytes are valid values; `None` for other types.
pub(crate) fn plain_size(ty: &DataType) -> Option<usize> {
    let plan = plan(ty.graph(), ty.ix(), false);
    let end = |length: usize, step: &Step| match step.what {
        What::Copy { bytes, .. } => length.next_multiple_of(step.align) + bytes,
        _ => length,
    };
    plan.is_plain().then(|| plan.steps.iter().fold(0, end))
}

/// Splits a message into its payload and whether that is big endian.
pub(crate) fn open<'a>(ty: &DataType, message: &'a [u8]) -> Result<(&'a [u8], bool), CdrError> {
    let wrong = |problem| CdrError { ty: ty.name().to_owned(), at: 0, problem };
    match message {
        [0, 0, _, _, payload @ ..] => Ok((payload, true)),
        [0, 1, _, _, payload @ ..] => Ok((payload, false)),
        [a, b, _, _, ..] => Err(wrong(CdrProblem::Representation(u16::from_be_bytes([*a, *b])))),
        _ => Err(wrong(CdrProblem::Truncated { needed: HEADER.len(), left: message.len() })),
    }
}
