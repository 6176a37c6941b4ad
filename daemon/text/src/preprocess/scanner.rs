//! Splits the logical text of one file into preprocessing tokens.
//!
//! It handles comments, literals and lines, but no macros or directives: the caller says when it is
//! inside a directive, where the line end is a token and ends strings.

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::ptoken::{Kind, PToken, Text};
use crate::source::{Logical, Span};

/// A file being read.
#[derive(Debug)]
pub(crate) struct Scanner {
    source: Logical,
    file: u32,
    buffer: u32,
    at: usize,
    first: bool,
    /// Inside a directive: line ends are tokens, and literals end with the line.
    pub(crate) directive: bool,
    /// Inside a skipped group or a message: no errors are reported.
    pub(crate) quiet: bool,
    /// The first string that crossed a line end: the likely place of a forgotten quote.
    long_string: Option<Span>,
    /// A string was never closed: from then on strings end with their line.
    unclosed: bool,
}

impl Scanner {
    pub(crate) fn new(source: Logical, file: u32, buffer: u32) -> Self {
        let at = if source.text.starts_with('\u{feff}') { '\u{feff}'.len_utf8() } else { 0 };
        Self {
            source,
            file,
            buffer,
            at,
            first: true,
            directive: false,
            quiet: false,
            long_string: None,
            unclosed: false,
        }
    }

    /// The next token.
    pub(crate) fn next(&mut self, diagnostics: &mut Diagnostics) -> PToken {
        let space = self.skip_blanks(diagnostics) || self.first;
        let start = self.at;
        let first = self.first;
        let Some(byte) = self.byte(0) else {
            return self.token(Kind::End, start, space, true);
        };
        self.first = false;
        let kind = match byte {
            b'\n' => {
                self.at += 1;
                self.first = true;
                Kind::Newline
            }
            b'a'..=b'z' | b'A'..=b'Z' | b'_' => {
                self.skip_word();
                Kind::Identifier
            }
            b'0'..=b'9' => self.number(),
            b'.' if self.byte(1).is_some_and(|next| next.is_ascii_digit()) => self.number(),
            b'"' => self.string(diagnostics),
            b'\'' => self.character(diagnostics),
            _ => self.punctuation(),
        };
        self.token(kind, start, space, first)
    }

    fn byte(&self, ahead: usize) -> Option<u8> {
        self.source.text.as_bytes().get(self.at + ahead).copied()
    }

    fn token(&self, kind: Kind, start: usize, space: bool, first: bool) -> PToken {
        let text = Text { buffer: self.buffer, start: offset(start), end: offset(self.at) };
        PToken { kind, text, span: self.span(start, self.at), space, first, frozen: false }
    }

    fn span(&self, start: usize, end: usize) -> Span {
        let first = self.source.original(offset(start));
        let last = if end > start {
            // A joined line directly after the token is not part of it.
            self.source.original(offset(end - 1)) + 1
        } else {
            first
        };
        Span { file: self.file, start: first, end: last }
    }

    /// Skips blanks and comments, and outside directives also line ends.
    fn skip_blanks(&mut self, diagnostics: &mut Diagnostics) -> bool {
        let begin = self.at;
        loop {
            match (self.byte(0), self.byte(1)) {
                (Some(b'\n'), _) if self.directive => break,
                (Some(b'\n'), _) => {
                    self.first = true;
                    self.at += 1;
                }
                (Some(b' ' | b'\t' | b'\r' | 0x0b | 0x0c), _) => self.at += 1,
                (Some(b'/'), Some(b'/')) => {
                    let rest = self.source.text.as_bytes().get(self.at..).unwrap_or_default();
                    self.at += rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
                }
                (Some(b'/'), Some(b'*')) => self.comment(diagnostics),
                _ => break,
            }
        }
        self.at > begin
    }

    fn comment(&mut self, diagnostics: &mut Diagnostics) {
        let body = self.at + 2;
        let found = self.source.text.get(body..).and_then(|rest| rest.find("*/"));
        if let Some(length) = found {
            self.at = body + length + 2;
            return;
        }
        // An intended difference: GenoM3's preprocessor drops the rest silently.
        let span = self.span(self.at, body);
        self.at = self.source.text.len();
        if !self.quiet {
            diagnostics.push(
                Diagnostic::error("E0102", span, "unterminated comment")
                    .label("this comment is never closed")
                    .help("close it with `*/`"),
            );
        }
    }

    fn skip_word(&mut self) {
        while self.byte(0).is_some_and(|byte| byte.is_ascii_alphanumeric() || byte == b'_') {
            self.at += 1;
        }
    }

    fn number(&mut self) -> Kind {
        while let Some(byte) = self.byte(0) {
            match byte {
                b'e' | b'E' if matches!(self.byte(1), Some(b'+' | b'-')) => self.at += 2,
                b'.' | b'_' => self.at += 1,
                _ if byte.is_ascii_alphanumeric() => self.at += 1,
                _ => break,
            }
        }
        Kind::Number
    }

    /// Reads a string, which may contain line ends outside directives. A backslash escapes the next
    /// character, so `"foo\\"` ends at its last quote (an intended difference: genom3.md 2.1).
    fn string(&mut self, diagnostics: &mut Diagnostics) -> Kind {
        let start = self.at;
        let one_line = self.directive || self.unclosed;
        let mut line_end = None;
        self.at += 1;
        loop {
            match self.byte(0) {
                Some(b'"') => {
                    self.at += 1;
                    if line_end.is_some() && self.long_string.is_none() {
                        self.long_string = Some(self.span(start, start + 1));
                    }
                    return Kind::String;
                }
                Some(b'\n') if one_line => {
                    line_end = Some(self.at);
                    break;
                }
                Some(b'\n') => {
                    line_end = line_end.or(Some(self.at));
                    self.at += 1;
                }
                Some(b'\\') if self.byte(1).is_some_and(|next| next != b'\n') => self.at += 2,
                Some(_) => self.at += 1,
                None => break,
            }
        }
        // Never closed: continue after the line where it began.
        self.at = self.boundary(line_end.unwrap_or(self.source.text.len()));
        self.unclosed |= !self.directive;
        if !self.quiet {
            let mut diagnostic =
                Diagnostic::error("E0114", self.span(start, start + 1), "unterminated string")
                    .label("this string is never closed")
                    .help("close it with `\"`");
            if let Some(long) = self.long_string {
                diagnostic =
                    diagnostic.note(long, "this string goes over several lines: is it meant to?");
            }
            diagnostics.push(diagnostic);
        }
        Kind::String
    }

    fn character(&mut self, diagnostics: &mut Diagnostics) -> Kind {
        let start = self.at;
        self.at += 1;
        loop {
            match self.byte(0) {
                Some(b'\'') => {
                    self.at += 1;
                    return Kind::Char;
                }
                Some(b'\n') | None => break,
                Some(b'\\') if self.byte(1).is_some_and(|next| next != b'\n') => self.at += 2,
                Some(_) => self.at += 1,
            }
        }
        if !self.quiet {
            diagnostics.push(
                Diagnostic::error(
                    "E0115",
                    self.span(start, start + 1),
                    "unterminated character literal",
                )
                .label("this quote is never closed on its line")
                .help("write a character as `'x'` and a text as `\"text\"`"),
            );
        }
        // Only the quote is dropped: what follows may be valid.
        self.at = start + 1;
        Kind::Char
    }

    fn punctuation(&mut self) -> Kind {
        let rest = self.source.text.get(self.at..).unwrap_or_default();
        let bytes = rest.as_bytes();
        let length = match bytes {
            [b'.', b'.', b'.', ..] => 3,
            _ => sign_length(rest),
        };
        self.at += length;
        match bytes.first() {
            Some(
                b'{' | b'}' | b'[' | b']' | b'(' | b')' | b';' | b':' | b'?' | b'.' | b'+' | b'-'
                | b'*' | b'/' | b'%' | b'^' | b'&' | b'|' | b'~' | b'!' | b'=' | b'<' | b'>' | b','
                | b'#',
            ) => Kind::Punctuation,
            _ => Kind::Stray,
        }
    }

    /// The nearest character boundary at or after `at`.
    fn boundary(&self, mut at: usize) -> usize {
        while at < self.source.text.len() && !self.source.text.is_char_boundary(at) {
            at += 1;
        }
        at.min(self.source.text.len())
    }
}

fn offset(at: usize) -> u32 {
    u32::try_from(at).unwrap_or(u32::MAX)
}

/// Length in bytes of the punctuation at the beginning of a text: one character, or two that form
/// one token.
#[must_use]
pub fn sign_length(rest: &str) -> usize {
    match rest.as_bytes() {
        // As in C++11, `<::` is `<` and `::` unless `:` or `>` follows, where `<:` is a digraph.
        [b'<', b':', b':', after, ..] if !matches!(after, b':' | b'>') => 1,
        [b':', b':', ..]
        | [b'<', b'<' | b'%' | b':', ..]
        | [b'>', b'>', ..]
        | [b'%' | b':', b'>', ..]
        | [b'#', b'#', ..] => 2,
        _ => rest.chars().next().map_or(1, char::len_utf8),
    }
}
