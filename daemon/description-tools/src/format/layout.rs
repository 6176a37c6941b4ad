//! Lines and indentation.

use super::pieces::{Piece, PieceKind};
use super::spacing::{Gap, spaced};

/// Blanks for each level of braces.
const INDENT: usize = 2;
/// Blanks before the continuation lines of a statement.
const CONTINUATION: usize = 4;
/// Braces nested deeper are not tracked across `#if` and `#else`.
const REMEMBERED: usize = 64;

/// An open brace.
#[derive(Clone, Copy, Debug)]
struct Group {
    /// It extends over several lines.
    broken: bool,
    /// It contains values or names separated by commas, not statements.
    list: bool,
    /// It contains values of an initialiser.
    tight: bool,
    /// Indentation of the line that opens it.
    base: usize,
}

pub(super) fn layout(pieces: &[Piece<'_>]) -> String {
    let groups = groups(pieces);
    let mut page = Page::default();
    let mut last: Option<usize> = None;
    let mut before: Option<usize> = None;
    for (rank, piece) in pieces.iter().enumerate() {
        let previous = rank.checked_sub(1).and_then(|rank| pieces.get(rank));
        let closing = is_closing(piece);
        if piece.kind == PieceKind::Directive {
            page.conditional(piece.text);
        }
        let after = last.and_then(|last| pieces.get(last));
        if page.breaks(previous, after, piece) {
            let blank = piece.newlines > 1 && previous.is_some() && !closing;
            let opened = after.is_some_and(is_opening);
            page.end_line(blank && !(opened && previous.is_some_and(is_opening)));
            if piece.kind != PieceKind::Directive {
                page.indent(after, piece);
            }
        } else if let Some(left) = previous {
            let tight = page.open.last().is_some_and(|group| group.tight);
            let before = before.and_then(|before| pieces.get(before));
            let gap = Gap { before, left, right: piece, tight };
            if spaced(&gap) {
                page.out.push(' ');
            }
        }
        page.write(piece);
        if is_opening(piece) {
            page.open_group(groups.get(rank).copied().flatten());
        } else if closing {
            page.open.pop();
        }
        if !matches!(piece.kind, PieceKind::Comment | PieceKind::Directive) {
            before = last;
            last = Some(rank);
        }
    }
    page.end_line(false);
    page.out
}

#[derive(Default)]
struct Page {
    out: String,
    /// Indentation of the current line.
    line: usize,
    /// Indentation of the line where the current statement begins.
    statement: usize,
    open: Vec<Group>,
    /// Open braces at each `#if`, with which its other groups begin too.
    saved: Vec<Vec<Group>>,
}

impl Page {
    /// Whether a line ends before `piece`. `after` is the last token; `previous` may also be a
    /// comment or directive.
    fn breaks(
        &self,
        previous: Option<&Piece<'_>>,
        after: Option<&Piece<'_>>,
        piece: &Piece<'_>,
    ) -> bool {
        let Some(previous) = previous else { return false };
        let directive = PieceKind::Directive;
        let line_comment = previous.kind == PieceKind::Comment && previous.text.starts_with("//");
        if previous.kind == directive || piece.kind == directive || line_comment {
            return true;
        }
        if piece.newlines > 0 && !matches!(piece.text, ";" | ",") {
            return true;
        }
        // A comment stays on the line of what it describes.
        if piece.kind == PieceKind::Comment {
            return false;
        }
        let statements = self.open.last().is_none_or(|group| group.broken && !group.list);
        let ends = after.is_some_and(|after| after.text == ";" || is_opening(after));
        statements && (ends || is_closing(piece))
    }

    fn end_line(&mut self, blank: bool) {
        let length = self.out.trim_end_matches(' ').len();
        self.out.truncate(length);
        if !self.out.is_empty() {
            self.out.push('\n');
            if blank {
                self.out.push('\n');
            }
        }
    }

    fn indent(&mut self, after: Option<&Piece<'_>>, piece: &Piece<'_>) {
        let group = self.open.last();
        let list = group.is_some_and(|group| group.list);
        let inner = group.map_or(0, |group| group.base + INDENT);
        let fresh = match after {
            None => true,
            Some(after) => {
                is_opening(after)
                    || matches!(after.text, ";" | "}" | "%>")
                    || (list && after.text == ",")
            }
        };
        self.line = if is_closing(piece) {
            group.map_or(0, |group| group.base)
        } else if fresh {
            inner
        } else {
            inner + CONTINUATION
        };
        if !list && (fresh || is_closing(piece)) {
            self.statement = self.line;
        }
        self.out.extend(std::iter::repeat_n(' ', self.line));
    }

    /// Statements are indented relative to the enclosing statement, values relative to their line.
    fn open_group(&mut self, group: Option<Group>) {
        let group = group.unwrap_or(Group { broken: false, list: false, tight: false, base: 0 });
        let base = if group.list { self.line } else { self.statement };
        self.open.push(Group { base, ..group });
    }

    /// Writes a piece. In comments of several lines, stars are aligned with the first one.
    fn write(&mut self, piece: &Piece<'_>) {
        if piece.kind != PieceKind::Comment || !piece.text.contains('\n') {
            self.out.push_str(piece.text);
            return;
        }
        let line_start = self.out.rfind('\n').map_or(0, |at| at + 1);
        let column = self.out.get(line_start..).map_or(0, |line| line.chars().count());
        for (rank, line) in piece.text.lines().enumerate() {
            if rank > 0 {
                self.out.push('\n');
                if line.trim_start().starts_with('*') {
                    self.out.extend(std::iter::repeat_n(' ', column + 1));
                    self.out.push_str(line.trim());
                    continue;
                }
            }
            self.out.push_str(line.trim_end());
        }
    }

    /// Tracks braces across conditional groups: those open at `#if` are open in its other groups
    /// too.
    fn conditional(&mut self, directive: &str) {
        let word = directive.trim_start_matches(['#', ' ', '\t']);
        if word.starts_with("if") && self.open.len() <= REMEMBERED {
            self.saved.push(self.open.clone());
        } else if word.starts_with("if") {
            self.saved.push(Vec::new());
        } else if word.starts_with("el") {
            if let Some(saved) = self.saved.last().filter(|_| self.open.len() <= REMEMBERED) {
                self.open.clone_from(saved);
            }
        } else if word.starts_with("endif") {
            self.saved.pop();
        }
    }
}

/// Properties of each opening brace, by index of its piece.
fn groups(pieces: &[Piece<'_>]) -> Vec<Option<Group>> {
    let mut groups: Vec<Option<Group>> = vec![None; pieces.len()];
    // Index, lines seen before it, and whether a statement ends inside.
    let mut open: Vec<(usize, usize, bool)> = Vec::new();
    let mut lines = 0;
    for (rank, piece) in pieces.iter().enumerate() {
        lines += piece.newlines + piece.text.matches('\n').count();
        lines += usize::from(piece.kind == PieceKind::Directive || piece.text.starts_with("//"));
        if is_opening(piece) {
            open.push((rank, lines, false));
        } else if piece.text == ";" {
            if let Some((_, _, statements)) = open.last_mut() {
                *statements = true;
            }
        } else if is_closing(piece)
            && let Some((start, before, statements)) = open.pop()
            && let Some(group) = groups.get_mut(start)
        {
            let list = !statements && rank > start + 1;
            let left = start.checked_sub(1).and_then(|left| pieces.get(left));
            let value = left.is_some_and(|left| matches!(left.text, "=" | "," | "{" | "("));
            *group = Some(Group { broken: lines > before, list, tight: list && value, base: 0 });
        }
    }
    groups
}

fn is_opening(piece: &Piece<'_>) -> bool {
    matches!(piece.text, "{" | "<%")
}

fn is_closing(piece: &Piece<'_>) -> bool {
    matches!(piece.text, "}" | "%>")
}
