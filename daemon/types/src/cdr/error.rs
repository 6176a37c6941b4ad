//! Errors of encoding and decoding CDR.

use thiserror::Error;

/// A value that cannot be encoded or bytes that cannot be decoded.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{ty} at byte {at} of the CDR payload: {problem}")]
pub struct CdrError {
    /// Spelling of the type being encoded or decoded there.
    pub ty: String,
    /// Offset in the payload, in bytes.
    pub at: usize,
    /// What is wrong there.
    pub problem: CdrProblem,
}

/// What is wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CdrProblem {
    /// The message ends too early.
    #[error("{needed} bytes are needed and {left} are left; the message is cut or of another type")]
    Truncated {
        /// Bytes needed.
        needed: usize,
        /// Bytes left.
        left: usize,
    },
    /// A length that the bound or the bytes left do not allow.
    #[error("length {length}, at most {most} is possible")]
    Length {
        /// The length in the message.
        length: usize,
        /// The greatest length possible there.
        most: usize,
    },
    /// A boolean that is neither 0 nor 1.
    #[error("{0} is no boolean")]
    Boolean(u8),
    /// An enum out of range.
    #[error("{value} is no enumerator, there are {count}")]
    Enumerator {
        /// Number in the message.
        value: u32,
        /// Number of enumerators.
        count: u32,
    },
    /// A string without its NUL at the end, or with one inside.
    #[error("a string needs one NUL, at its end")]
    Nul,
    /// A string that is not UTF-8.
    #[error("a string is not UTF-8")]
    Utf8,
    /// A union whose members do not fit its discriminant.
    #[error("the members present do not fit the discriminant")]
    Union,
    /// Sequences nested too deep.
    #[error("nested deeper than {0} sequences")]
    Deep(usize),
    /// More memory than a message of this size may ask for.
    #[error("the value takes too much memory for a message of this size")]
    Memory,
    /// A native type: only codels know its content.
    #[error("a native type has no CDR form; keep it out of ports and service parameters")]
    Native,
    /// An encapsulation other than plain CDR.
    #[error("representation {0:#06x} is not plain CDR (0x0000, 0x0001)")]
    Representation(u16),
}
