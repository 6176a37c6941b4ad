//! Places in the text.

/// A place in the source, resolved through the source map of its specification.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Span {
    /// File, by its rank in the source map.
    pub file: u32,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// From the start of this place to the end of `last`, if both are in one file.
    #[must_use]
    pub fn to(self, last: Span) -> Span {
        if self.file == last.file && last.end >= self.start {
            Span { end: last.end.max(self.end), ..self }
        } else {
            self
        }
    }
}
