//! Words of a description, with their positions.

use std::rc::Rc;

use crate::model::Span;

/// An identifier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Name {
    /// As written.
    pub text: Rc<str>,
    /// Position in the text.
    pub span: Span,
}

/// A name with its scopes, such as `::demo::state`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    /// Whether it starts with `::`.
    pub absolute: bool,
    /// The names between `::`, at least one.
    pub segments: Vec<Name>,
    /// Span of the whole path.
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
    /// Contents of the literals without quotes, concatenated.
    pub text: String,
    /// Span of all literals.
    pub span: Span,
}
