//! Why a text is left as it is.

/// Why a text is left as it is.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FormatError {
    /// A comment or string has no end.
    #[error("line {line}: this {what} is never closed")]
    Unclosed {
        /// Where it begins.
        line: u32,
        /// Comment, string or character.
        what: &'static str,
    },
    /// A line is joined to the next outside a directive, or a trigraph is used.
    #[error("line {line}: joined lines and trigraphs cannot be formatted; write them out")]
    Joined {
        /// Where it is.
        line: u32,
    },
    /// A character that has no place outside strings, comments and directives.
    #[error("line {line}: stray `{what}`")]
    Stray {
        /// Where it is.
        line: u32,
        /// Character that no token begins with.
        what: char,
    },
    /// The result would not mean the same: a mistake of the formatter.
    #[error("the formatter would change the meaning of this text; please report it")]
    Changed,
}
