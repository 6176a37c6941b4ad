//! Why a text cannot be formatted.

/// Why a text cannot be formatted; it is left as it is.
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
    /// A line is continued outside a directive, or a trigraph is used.
    #[error("line {line}: joined lines and trigraphs cannot be formatted; write them out")]
    Joined {
        /// Its line, from 1.
        line: u32,
    },
    /// A character that is not allowed outside strings, comments and directives.
    #[error("line {line}: stray `{what}`")]
    Stray {
        /// Its line, from 1.
        line: u32,
        /// The character.
        what: char,
    },
    /// The result would not have the same meaning: a defect of the formatter.
    #[error("the formatter would change the meaning of this text; please report it")]
    Changed,
}
