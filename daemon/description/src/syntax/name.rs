//! Words of a description, with their places.

use std::rc::Rc;

use crate::model::Span;

/// An identifier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// As written.
    pub text: Rc<str>,
    /// Where.
    pub span: Span,
}

/// A name with its scopes, such as `::demo::state`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    /// Starts with `::`.
    pub absolute: bool,
    /// At least one.
    pub segments: Vec<Name>,
    /// The whole of it.
    pub span: Span,
}

impl std::fmt::Display for Path {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for (rank, segment) in self.segments.iter().enumerate() {
            if rank > 0 || self.absolute {
                f.write_str("::")?;
            }
            f.write_str(&segment.text)?;
        }
        Ok(())
    }
}

/// Adjacent string literals, joined.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Text {
    /// Contents of the literals, one after the other, without quotes.
    pub text: String,
    /// All of the literals.
    pub span: Span,
}
