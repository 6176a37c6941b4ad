//! Decides whether a blank separates two pieces of one line.

use super::pieces::{Piece, PieceKind};

/// The pieces around a gap.
pub(super) struct Gap<'p, 't> {
    pub(super) before: Option<&'p Piece<'t>>,
    pub(super) left: &'p Piece<'t>,
    pub(super) right: &'p Piece<'t>,
    /// The innermost braces contain values: no blank between brace and value.
    pub(super) tight: bool,
}

/// Whether the gap is a blank.
pub(super) fn spaced(gap: &Gap<'_, '_>) -> bool {
    let (left, right) = (gap.left, gap.right);
    if left.kind == PieceKind::Comment || right.kind == PieceKind::Comment {
        return true;
    }
    if glues(left.text, right.text) {
        return true;
    }
    match (left.text, right.text) {
        ("{" | "<%", "}" | "%>") => false,
        ("{" | "<%", _) | (_, "}" | "%>") => !gap.tight,
        (_, ";" | "," | ":") => false,
        ("(" | "[" | "<:", _) | (_, ")" | "]" | ":>") => false,
        ("<", _) | (_, "<" | ">") => false,
        ("::", _) => false,
        (_, "::") => right.space || !operand(left),
        (".", _) => false,
        (left, ".") => !operand(gap.left) || left == ")",
        (">", "(") => true,
        (left, "(" | "[" | "<:") => !operand(gap.left) || left == "switch",
        ("~" | "!", _) => false,
        ("-" | "+", _) => !unary(gap),
        _ => true,
    }
}

/// Whether two pieces without a blank would be read as other tokens: `< ::`, `> >`, `1 .`.
fn glues(left: &str, right: &str) -> bool {
    let (Some(end), Some(start)) = (left.bytes().last(), right.bytes().next()) else {
        return false;
    };
    match (end, start) {
        (b'<', b'<' | b'%' | b':')
        | (b'>', b'>')
        | (b':', b':' | b'>')
        | (b'%', b'>')
        | (b'/', b'/' | b'*')
        | (b'?', b'?')
        | (b'.', b'0'..=b'9' | b'.') => true,
        (_, b'.') => left.starts_with(|c: char| c.is_ascii_digit() || c == '.'),
        _ => false,
    }
}

/// Whether the operator left of the gap is unary, and belongs to what follows.
fn unary(gap: &Gap<'_, '_>) -> bool {
    // Words after which a value begins.
    const BEFORE_VALUES: &[&str] =
        &["period", "delay", "case", "clock-rate", "priority", "stack", "wcet"];
    !gap.before.is_some_and(|piece| operand(piece) && !BEFORE_VALUES.contains(&piece.text))
}

/// Whether an operand may end with this piece.
fn operand(piece: &Piece<'_>) -> bool {
    piece.kind == PieceKind::Word || matches!(piece.text, ")" | "]" | ":>")
}
