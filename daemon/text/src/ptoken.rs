//! What the preprocessor cuts, expands and hands to the lexer.

use crate::source::Span;

/// What a preprocessing token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Identifier,
    /// Anything that begins like a number, such as `5ms` or `0x1F`; cut further by the lexer.
    Number,
    /// With its quotes.
    String,
    /// With its quotes.
    Char,
    /// One character, or `::`, `<<`, `>>`, a digraph, `##`, `...`.
    Punctuation,
    /// A character with no meaning in the language.
    Stray,
    /// End of a directive.
    Newline,
    End,
}

/// Bytes `start..end` of a text buffer of the preprocessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Text {
    pub(crate) buffer: u32,
    pub(crate) start: u32,
    pub(crate) end: u32,
}

/// A preprocessing token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PToken {
    pub(crate) kind: Kind,
    pub(crate) text: Text,
    pub(crate) span: Span,
    /// Blanks, a comment or a line end come before it.
    pub(crate) space: bool,
    /// It is the first of its line, where `#` begins a directive.
    pub(crate) first: bool,
    /// A macro name met inside its own expansion: never expanded again.
    pub(crate) frozen: bool,
}
