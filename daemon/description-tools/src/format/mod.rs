//! The formatter: it changes indentation, blanks and blank lines, never a token, comment or
//! directive.
//!
//! Like gofmt it keeps the author's line breaks: it adds some after statements, and removes none.

mod error;
mod layout;
mod pieces;
mod spacing;

use genom_text::source::decode;

pub use error::FormatError;
use pieces::{Piece, PieceKind, pieces};

/// The text with normal indentation and spacing; formatting the result again changes nothing.
///
/// # Errors
/// When the text cannot be split into tokens. Their meaning is not checked.
pub fn format_text(text: &str) -> Result<String, FormatError> {
    let found = pieces(text)?;
    let out = layout::layout(&found);
    let same = |a: &Piece<'_>, b: &Piece<'_>| {
        a.kind == b.kind
            && match a.kind {
                PieceKind::Comment | PieceKind::Directive => normal(a.text) == normal(b.text),
                _ => a.text == b.text,
            }
    };
    let again = pieces(&out).map_err(|_| FormatError::Changed)?;
    let unchanged = again.len() == found.len() && found.iter().zip(&again).all(|(a, b)| same(a, b));
    if unchanged { Ok(out) } else { Err(FormatError::Changed) }
}

/// The bytes of a file with normal indentation and spacing, in the encoding of the file.
///
/// # Errors
/// As [`format_text`].
pub fn format_bytes(bytes: &[u8]) -> Result<Vec<u8>, FormatError> {
    let (text, encoding) = decode(bytes.to_vec());
    format_text(&text).map(|text| encoding.encode(&text))
}

/// The lines of a comment or directive without the blanks around them, for comparison.
fn normal(text: &str) -> Vec<&str> {
    text.lines().map(str::trim).collect()
}
