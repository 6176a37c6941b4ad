//! The lexer proper (genom3.md 2.1): from preprocessing tokens to tokens for the parser.
//!
//! It sees one token at a time and never the text: comments, lines and macros have been handled
//! before.

mod literal;
mod number;
mod words;

pub(crate) use literal::{character, unescape};

/// Whether a text can be a name.
#[must_use]
pub fn is_name(text: &str) -> bool {
    let sound = text.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_');
    let begins = text.bytes().next().is_some_and(|byte| !byte.is_ascii_digit());
    let free = words::keyword(text).is_none() && words::word_operator(text).is_none();
    sound && begins && free && text.len() <= LONGEST
}

use std::collections::HashSet;
use std::rc::Rc;

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::ptoken::{Kind, PToken};
use crate::source::Span;
use crate::token::{Pragma, Token, TokenKind};

/// Bytes of the longest name and of the longest number, so that C names composed of several names
/// stay within what compilers accept.
const LONGEST: usize = 1024;

/// Collects the tokens.
#[derive(Debug, Default)]
pub(crate) struct Lexer {
    tokens: Vec<Token>,
    /// All names so far: equal names share one string.
    names: HashSet<Rc<str>>,
    /// Index of a `-` directly after the token before it, for names such as `clock-rate`.
    dash: Option<usize>,
    /// End of the last stray character: several in a row are reported once.
    stray: Option<Span>,
}

impl Lexer {
    /// The next preprocessing token.
    pub(crate) fn take(&mut self, token: PToken, text: &str, diagnostics: &mut Diagnostics) {
        let span = token.span;
        match token.kind {
            Kind::Identifier if text.len() > LONGEST => {
                let message = format!("a name of {} characters", text.len());
                diagnostics.push(
                    Diagnostic::error("E0117", span, message)
                        .help(format!("names have at most {LONGEST}")),
                );
                self.word(text.get(..LONGEST).unwrap_or_default(), span, token.space);
            }
            Kind::Identifier => self.word(text, span, token.space),
            Kind::Number if text.len() > LONGEST => {
                let message = format!("a number of {} characters", text.len());
                diagnostics.push(Diagnostic::error("E0116", span, message));
                self.push(TokenKind::Integer(0), span);
            }
            Kind::Number => {
                for (kind, part) in number::cut(text, span, diagnostics) {
                    match kind {
                        TokenKind::Identifier(word) => self.word(&word, part, false),
                        kind => self.push(kind, part),
                    }
                }
            }
            Kind::String => {
                if text.contains('\0') {
                    let message = "a string cannot hold a NUL character";
                    diagnostics.push(Diagnostic::error("E0101", span, message));
                }
                self.push(TokenKind::String(unescape(text).into()), span);
            }
            // A quote without partner was already reported by the scanner.
            Kind::Char if text.len() < 2 => {}
            Kind::Char => {
                let value = character(text);
                if value.is_none() {
                    let message = format!("{text} is not one character of one byte");
                    diagnostics.push(
                        Diagnostic::error("E0115", span, message)
                            .help("write a character as `'x'` or `'\\n'`, a text as `\"text\"`"),
                    );
                }
                self.push(TokenKind::Char(value.unwrap_or_default()), span);
            }
            Kind::Punctuation => match words::punctuation(text) {
                Some(sign) => {
                    let touching = sign == "-" && !token.space;
                    self.push(TokenKind::Punctuation(sign), span);
                    self.dash = touching.then(|| self.tokens.len() - 1);
                }
                None if text == "..." => {
                    for _ in 0..3 {
                        self.push(TokenKind::Punctuation("."), span);
                    }
                }
                None => self.stray(text, span, diagnostics),
            },
            Kind::Stray => self.stray(text, span, diagnostics),
            Kind::Newline | Kind::End => {}
        }
    }

    /// Adds a pragma that the parser handles.
    pub(crate) fn pragma(&mut self, pragma: Pragma, span: Span) {
        self.push(TokenKind::Pragma(Box::new(pragma)), span);
    }

    /// Number of tokens so far.
    pub(crate) fn len(&self) -> usize {
        self.tokens.len()
    }

    /// All tokens, with [`TokenKind::End`] at `end`.
    pub(crate) fn finish(mut self, end: Span) -> Vec<Token> {
        self.push(TokenKind::End, end);
        self.tokens
    }

    fn push(&mut self, kind: TokenKind, span: Span) {
        self.tokens.push(Token { kind, span });
    }

    fn word(&mut self, text: &str, span: Span, space: bool) {
        if !space
            && let Some(dash) = self.dash.take()
            && dash + 1 == self.tokens.len()
            && let Some(before) = dash.checked_sub(1).and_then(|at| self.tokens.get(at))
            && let TokenKind::Identifier(first) = &before.kind
            && words::is_dashed(first, text)
        {
            let whole = format!("{first}-{text}");
            let start = before.span;
            let span =
                if start.file == span.file { Span { end: span.end, ..start } } else { start };
            self.tokens.truncate(dash - 1);
            let whole = self.name(&whole);
            self.push(TokenKind::Identifier(whole), span);
            return;
        }
        let kind = words::keyword(text)
            .map(TokenKind::Keyword)
            .or_else(|| words::word_operator(text).map(TokenKind::Punctuation))
            .unwrap_or_else(|| TokenKind::Identifier(self.name(text)));
        self.push(kind, span);
    }

    /// The shared string of a name.
    fn name(&mut self, text: &str) -> Rc<str> {
        if let Some(known) = self.names.get(text) {
            return known.clone();
        }
        let name: Rc<str> = text.into();
        self.names.insert(name.clone());
        name
    }

    fn stray(&mut self, text: &str, span: Span, diagnostics: &mut Diagnostics) {
        let follows =
            self.stray.is_some_and(|last| last.file == span.file && last.end == span.start);
        self.stray = Some(span);
        if follows {
            return;
        }
        let shown = text.chars().next().map_or_else(String::new, |c| c.escape_debug().to_string());
        diagnostics.push(
            Diagnostic::error("E0101", span, format!("stray character `{shown}`"))
                .label("it has no meaning here"),
        );
    }
}
