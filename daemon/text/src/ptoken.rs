//! Preprocessing tokens: made by the scanner, expanded by the preprocessor, taken by the lexer.

use crate::source::Span;

/// Kinds of preprocessing tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Identifier,
    /// Anything that begins like a number, such as `5ms` or `0x1F`; the lexer splits it.
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
    /// Blanks, a comment or a line end precede it.
    pub(crate) space: bool,
    /// It is the first of its line, where `#` begins a directive.
    pub(crate) first: bool,
    /// A macro name met inside its own expansion: never expanded again.
    pub(crate) frozen: bool,
}
