//! Tokens, as the lexer makes them for the parser.

use std::rc::Rc;

use crate::source::Span;

/// A token and its position in the source.
#[derive(Clone, Debug, PartialEq)]
pub struct Token {
    /// Kind and value of the token.
    pub kind: TokenKind,
    /// Position; a token made by a macro has the position where the macro is used.
    pub span: Span,
}

/// Kinds of tokens (genom3.md 2.1). Contextual keywords are identifiers: the parser decides.
#[derive(Clone, Debug, PartialEq)]
pub enum TokenKind {
    /// Identifier or contextual keyword, also `clock-rate`, `codels-require(s)`, `real-time`.
    /// Equal names share one string, since descriptions consist mostly of names.
    Identifier(Rc<str>),
    /// Reserved keyword, as spelled in genom3.md 2.2 (`module`, `TRUE`, ...), but not the word
    /// operators, which come as [`TokenKind::Punctuation`].
    Keyword(&'static str),
    /// Integer literal: 64 bits kept (an intended difference from GenoM3).
    Integer(u64),
    /// Floating point literal.
    Float(f64),
    /// Fixed point literal (suffix `d`): always an error, reported by the parser.
    Fixed,
    /// Character literal: its code.
    Char(u8),
    /// One string literal, `\"` unescaped. Adjacent ones are joined by the parser.
    String(Box<str>),
    /// Punctuation in its main spelling: digraphs and word operators are replaced (`<%` by `{`,
    /// `xor` by `^`). `::`, `<<` and `>>` are single tokens.
    Punctuation(&'static str),
    /// A `#pragma` line that the parser handles; boxed because it is rare and large.
    Pragma(Box<Pragma>),
    /// End of the input files: always the last token, exactly once.
    End,
}

/// Pragmas that the parser handles (genom3.md 1.3); each argument with its position.
#[derive(Clone, Debug, PartialEq)]
pub enum Pragma {
    /// `#pragma requires "pkg" ...`
    Requires(Vec<(Box<str>, Span)>),
    /// `#pragma provides IFACE ...`
    Provides(Vec<(Box<str>, Span)>),
    /// `#pragma masquerade TEMPLATE TYPE DATA`, arguments as found: the parser counts them.
    Masquerade(Vec<(Box<str>, Span)>),
}
