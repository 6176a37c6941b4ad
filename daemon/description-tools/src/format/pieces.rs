//! Splits a text into tokens, comments and directives, each kept as written.

use genom_text::preprocess::sign_length;

use super::error::FormatError;

/// What a piece is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PieceKind {
    /// Name, number, string or character.
    Word,
    Sign,
    /// `// ...` or `/* ... */`.
    Comment,
    /// A whole directive with its continuation lines.
    Directive,
}

/// A piece of text.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<'t> {
    pub(super) kind: PieceKind,
    pub(super) text: &'t str,
    /// Number of line ends before it.
    pub(super) newlines: usize,
    /// Whether blanks or line ends precede it.
    pub(super) space: bool,
}

pub(super) fn pieces(text: &str) -> Result<Vec<Piece<'_>>, FormatError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut cutter = Cutter { text, at: 0, line: 1 };
    let mut pieces: Vec<Piece<'_>> = Vec::new();
    loop {
        let (newlines, space) = cutter.blanks();
        let newlines = if pieces.is_empty() { newlines.max(1) } else { newlines };
        let start = cutter.at;
        let Some(kind) = cutter.piece(newlines > 0)? else { return Ok(pieces) };
        let whole = text.get(start..cutter.at).unwrap_or_default();
        cutter.line += u32::try_from(whole.matches('\n').count()).unwrap_or(0);
        let piece = Piece { kind, text: whole, newlines, space };
        match dashed(&pieces, &piece) {
            // `clock-rate` is one name, and must stay in one piece.
            true => {
                pieces.truncate(pieces.len() - 1);
                if let Some(first) = pieces.last_mut() {
                    let begin = start - 1 - first.text.len();
                    first.text = text.get(begin..cutter.at).unwrap_or_default();
                }
            }
            false => pieces.push(piece),
        }
    }
}

fn dashed(before: &[Piece<'_>], last: &Piece<'_>) -> bool {
    let [.., first, dash] = before else { return false };
    dash.text == "-"
        && !dash.space
        && !last.space
        && matches!(
            (first.text, last.text),
            ("clock", "rate") | ("codels", "require" | "requires") | ("real", "time")
        )
}

struct Cutter<'t> {
    text: &'t str,
    at: usize,
    line: u32,
}

impl Cutter<'_> {
    fn byte(&self, ahead: usize) -> Option<u8> {
        self.text.as_bytes().get(self.at + ahead).copied()
    }

    fn blanks(&mut self) -> (usize, bool) {
        let start = self.at;
        let mut newlines = 0;
        while let Some(byte) = self.byte(0) {
            match byte {
                b'\n' => newlines += 1,
                b' ' | b'\t' | b'\r' | 0x0b | 0x0c => {}
                _ => break,
            }
            self.at += 1;
        }
        self.line += u32::try_from(newlines).unwrap_or(0);
        (newlines, self.at > start)
    }

    fn piece(&mut self, first: bool) -> Result<Option<PieceKind>, FormatError> {
        let Some(byte) = self.byte(0) else { return Ok(None) };
        let kind = match (byte, self.byte(1)) {
            (b'#', _) if first => self.directive()?,
            (b'/', Some(b'/')) => self.line_comment()?,
            (b'/', Some(b'*')) => {
                self.block_comment()?;
                PieceKind::Comment
            }
            (b'"', _) => self.quoted(b'"', "string")?,
            (b'\'', _) => self.quoted(b'\'', "character")?,
            (b'\\', Some(b'\n' | b'\r')) => return Err(FormatError::Joined { line: self.line }),
            (b'\\' | b'#', _) => {
                return Err(FormatError::Stray { line: self.line, what: char::from(byte) });
            }
            (b'?', Some(b'?')) => return Err(FormatError::Joined { line: self.line }),
            (b'0'..=b'9', _) => self.number(),
            (b'.', Some(b'0'..=b'9')) => self.number(),
            _ if is_name(byte) => {
                while self.byte(0).is_some_and(is_name) {
                    self.at += 1;
                }
                PieceKind::Word
            }
            _ => self.sign(),
        };
        // A backslash would continue the name or number on the next line.
        if kind == PieceKind::Word && self.byte(0) == Some(b'\\') {
            return Err(FormatError::Joined { line: self.line });
        }
        Ok(Some(kind))
    }

    fn number(&mut self) -> PieceKind {
        while let Some(byte) = self.byte(0) {
            match byte {
                b'e' | b'E' if matches!(self.byte(1), Some(b'+' | b'-')) => self.at += 2,
                b'.' => self.at += 1,
                _ if is_name(byte) => self.at += 1,
                _ => break,
            }
        }
        PieceKind::Word
    }

    /// Reads a directive up to the end of its last line; comments in it may contain line ends.
    fn directive(&mut self) -> Result<PieceKind, FormatError> {
        let start = self.at;
        while let Some(byte) = self.byte(0) {
            match (byte, self.byte(1)) {
                (b'\n', _) => break,
                (b'\\', Some(b'\n')) => self.at += 2,
                (b'\\', Some(b'\r')) if self.byte(2) == Some(b'\n') => self.at += 3,
                (b'/', Some(b'*')) => self.block_comment()?,
                (b'/', Some(b'/')) => {
                    self.line_comment()?;
                }
                (b'"', _) => self.string_in_line(),
                _ => self.at += 1,
            }
        }
        if is_if_0(self.text.get(start..self.at).unwrap_or_default()) {
            self.left_out();
        }
        self.trim()?;
        Ok(PieceKind::Directive)
    }

    /// Skips the lines that `#if 0` excludes, up to the directive that ends them. They need not be
    /// valid, and are kept as they are.
    fn left_out(&mut self) {
        let mut depth = 0_usize;
        while self.byte(0) == Some(b'\n') {
            let before = self.at;
            self.at += 1;
            match self.line_left_out().as_str() {
                "if" | "ifdef" | "ifndef" => depth += 1,
                "endif" if depth > 0 => depth -= 1,
                "endif" | "else" | "elif" if depth == 0 => {
                    self.at = before;
                    return;
                }
                _ => {}
            }
        }
        // Never closed: blanks at the end of the text are not part of it.
        self.at = self.text.get(..self.at).unwrap_or_default().trim_end().len();
    }

    /// Skips one line with its continuation lines; returns its directive, if it is one.
    fn line_left_out(&mut self) -> String {
        let mut directive = String::new();
        let mut first = true;
        while let Some(byte) = self.byte(0) {
            match (byte, self.byte(1)) {
                (b'\n', _) => break,
                (b'\\', Some(b'\n')) => self.at += 2,
                (b'\\', Some(b'\r')) if self.byte(2) == Some(b'\n') => self.at += 3,
                (b'/', Some(b'/')) => {
                    let rest = self.text.get(self.at..).unwrap_or_default();
                    self.at += rest.find('\n').unwrap_or(rest.len());
                }
                (b'/', Some(b'*')) => {
                    let rest = self.text.get(self.at + 2..).unwrap_or_default();
                    self.at += rest.find("*/").map_or(rest.len() + 2, |length| length + 4);
                }
                (b' ' | b'\t' | b'\r' | 0x0b | 0x0c, _) => self.at += 1,
                (b'#', _) if first => {
                    first = false;
                    let rest = self
                        .text
                        .get(self.at + 1..)
                        .unwrap_or_default()
                        .trim_start_matches([' ', '\t']);
                    let end = rest.find(|c: char| !c.is_ascii_alphanumeric());
                    directive =
                        rest.get(..end.unwrap_or(rest.len())).unwrap_or_default().to_owned();
                    self.at += 1;
                }
                (quote @ (b'"' | b'\''), _) => {
                    first = false;
                    self.quoted_left_out(quote);
                }
                _ => {
                    first = false;
                    self.at += 1;
                }
            }
        }
        directive
    }

    /// Skips a string in excluded lines. It ends with its line at the latest; a quote without
    /// partner is a token of its own.
    fn quoted_left_out(&mut self, quote: u8) {
        let start = self.at;
        self.at += 1;
        while let Some(byte) = self.byte(0).filter(|byte| *byte != b'\n') {
            self.at +=
                if byte == b'\\' && self.byte(1).is_some_and(|next| next != b'\n') { 2 } else { 1 };
            if byte == quote {
                return;
            }
        }
        if quote == b'\'' {
            self.at = start + 1;
        }
    }

    fn string_in_line(&mut self) {
        self.at += 1;
        while let Some(byte) = self.byte(0) {
            match (byte, self.byte(1)) {
                (b'\n', _) => return,
                (b'\\', Some(next)) if next != b'\n' => self.at += 2,
                (b'"', _) => {
                    self.at += 1;
                    return;
                }
                _ => self.at += 1,
            }
        }
    }

    fn line_comment(&mut self) -> Result<PieceKind, FormatError> {
        let rest = self.text.get(self.at..).unwrap_or_default();
        self.at += rest.find('\n').unwrap_or(rest.len());
        self.trim()?;
        Ok(PieceKind::Comment)
    }

    /// Removes blanks at the end of a piece. A backslash before them is refused: it would become
    /// the last character of its line and continue it.
    fn trim(&mut self) -> Result<(), FormatError> {
        let before = self.text.get(..self.at).unwrap_or_default();
        let kept = before.trim_end_matches([' ', '\t', '\r', '\x0b', '\x0c']);
        let last_line = self.at == self.text.len() && kept.trim_end().ends_with('\\');
        if last_line || kept.ends_with('\\') {
            return Err(FormatError::Joined { line: self.line });
        }
        self.at = kept.len();
        Ok(())
    }

    fn block_comment(&mut self) -> Result<(), FormatError> {
        let rest = self.text.get(self.at + 2..).unwrap_or_default();
        match rest.find("*/") {
            Some(length) => {
                self.at += length + 4;
                Ok(())
            }
            None => Err(FormatError::Unclosed { line: self.line, what: "comment" }),
        }
    }

    fn quoted(&mut self, quote: u8, what: &'static str) -> Result<PieceKind, FormatError> {
        let line = self.line;
        self.at += 1;
        while let Some(byte) = self.byte(0) {
            self.at += 1;
            match byte {
                // A line continued inside a string is kept, as line ends are.
                b'\\' => self.at += usize::from(self.byte(0).is_some()),
                b'\n' if quote == b'\'' => break,
                _ if byte == quote => return Ok(PieceKind::Word),
                _ => {}
            }
        }
        Err(FormatError::Unclosed { line, what })
    }

    fn sign(&mut self) -> PieceKind {
        let rest = self.text.get(self.at..).unwrap_or_default();
        self.at += sign_length(rest);
        PieceKind::Sign
    }
}

/// Whether a directive is `#if 0`; blanks and comments in it are ignored.
fn is_if_0(directive: &str) -> bool {
    let rest = directive.trim_start_matches('#').trim_start();
    let condition = rest.strip_prefix("if").unwrap_or_default();
    let condition = condition.split("//").next().and_then(|text| text.split("/*").next());
    rest.starts_with("if") && condition.is_some_and(|text| text.trim() == "0")
}

fn is_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}
