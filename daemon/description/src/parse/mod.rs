//! Tokens to tree, by recursive descent.
//!
//! It never fails: after an error it skips to the end of the statement and continues. No name is
//! resolved; `check` does that.

mod codel;
mod expression;
mod initializer;
mod property;
mod service;
mod statement;
mod types;

use std::collections::HashSet;
use std::rc::Rc;

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::Span;
use crate::syntax::{Name, Tree};
use crate::token::{Pragma, Token, TokenKind};

/// Deepest nesting of braces, parentheses and templates.
pub const MAX_DEPTH: u32 = 100;

/// Reads a whole specification.
#[must_use]
pub fn parse(tokens: &[Token]) -> (Tree, Diagnostics) {
    let mut parser = Parser::new(tokens);
    let statements = parser.specification();
    (Tree { statements, lost: parser.lost }, parser.diagnostics)
}

/// The error was reported: the caller skips to the end of the statement.
#[derive(Debug)]
pub(crate) struct Recover;

pub(crate) type Parsed<T> = Result<T, Recover>;

const END: &TokenKind = &TokenKind::End;

pub(crate) struct Parser<'a> {
    tokens: &'a [Token],
    at: usize,
    /// Number of open `{` before the current token: recovery stops at the level where it started.
    braces: u32,
    depth: u32,
    /// Code of syntax errors here: bodies of types, IDS and parameters have their own.
    code: &'static str,
    /// The nesting is too deep: the rest is skipped without further errors.
    stopped: bool,
    /// Index of the token with the last error: at most one error is reported for a token.
    last_error: Option<usize>,
    /// An inner `>>` closed two templates, which is an error and was reported.
    half_closed: bool,
    diagnostics: Diagnostics,
    /// Pragmas read since the last statement.
    pragmas: Vec<(Pragma, Span)>,
    lost: HashSet<Rc<str>>,
}

impl<'a> Parser<'a> {
    fn new(tokens: &'a [Token]) -> Self {
        let mut parser = Parser {
            tokens,
            at: 0,
            braces: 0,
            depth: 0,
            code: "E0103",
            stopped: false,
            last_error: None,
            half_closed: false,
            diagnostics: Diagnostics::default(),
            pragmas: Vec::new(),
            lost: HashSet::new(),
        };
        parser.skip_pragmas();
        parser
    }

    fn kind(&self) -> &'a TokenKind {
        self.tokens.get(self.at).map_or(END, |token| &token.kind)
    }

    /// The token after the current one; pragmas are skipped.
    fn second(&self) -> &'a TokenKind {
        self.tokens
            .get(self.at + 1..)
            .unwrap_or_default()
            .iter()
            .map(|token| &token.kind)
            .find(|kind| !matches!(kind, TokenKind::Pragma(_)))
            .unwrap_or(END)
    }

    fn span(&self) -> Span {
        self.tokens.get(self.at).or(self.tokens.last()).map_or(Span::default(), |t| t.span)
    }

    /// From `start` to the token before the current one.
    fn since(&self, start: Span) -> Span {
        let last = self.at.checked_sub(1).and_then(|at| self.tokens.get(at));
        last.map_or(start, |token| start.to(token.span))
    }

    fn at_end(&self) -> bool {
        matches!(self.kind(), TokenKind::End)
    }

    fn bump(&mut self) {
        match self.kind() {
            TokenKind::End => return,
            TokenKind::Punctuation("{") => self.braces += 1,
            TokenKind::Punctuation("}") => self.braces = self.braces.saturating_sub(1),
            _ => {}
        }
        self.at += 1;
        self.skip_pragmas();
    }

    fn skip_pragmas(&mut self) {
        while let Some(Token { kind: TokenKind::Pragma(pragma), span }) = self.tokens.get(self.at) {
            self.pragmas.push(((**pragma).clone(), *span));
            self.at += 1;
        }
    }

    fn is(&self, punctuation: &str) -> bool {
        matches!(self.kind(), TokenKind::Punctuation(p) if *p == punctuation)
    }

    fn second_is(&self, punctuation: &str) -> bool {
        matches!(self.second(), TokenKind::Punctuation(p) if *p == punctuation)
    }

    fn eat(&mut self, punctuation: &str) -> bool {
        let found = self.is(punctuation);
        if found {
            self.bump();
        }
        found
    }

    fn expect(&mut self, punctuation: &str) -> Parsed<()> {
        if self.eat(punctuation) { Ok(()) } else { self.unexpected(&format!("`{punctuation}`")) }
    }

    /// The current identifier, which may be a contextual keyword.
    fn word(&self) -> Option<&'a str> {
        match self.kind() {
            TokenKind::Identifier(text) => Some(text),
            _ => None,
        }
    }

    fn is_word(&self, word: &str) -> bool {
        self.word() == Some(word)
    }

    fn eat_word(&mut self, word: &str) -> bool {
        let found = self.is_word(word);
        if found {
            self.bump();
        }
        found
    }

    fn is_keyword(&self, keyword: &str) -> bool {
        matches!(self.kind(), TokenKind::Keyword(k) if *k == keyword)
    }

    fn eat_keyword(&mut self, keyword: &str) -> bool {
        let found = self.is_keyword(keyword);
        if found {
            self.bump();
        }
        found
    }

    fn name(&mut self, what: &str) -> Parsed<Name> {
        match self.word() {
            Some(text) => {
                let name = Name { text: text.into(), span: self.span() };
                self.bump();
                Ok(name)
            }
            None => {
                let help = match self.kind() {
                    TokenKind::Keyword(keyword) => {
                        Some(format!("`{keyword}` is reserved: choose another name"))
                    }
                    _ => None,
                };
                self.refuse(self.code, what, help)
            }
        }
    }

    /// One or more, separated by commas.
    fn list<T>(&mut self, mut item: impl FnMut(&mut Self) -> Parsed<T>) -> Parsed<Vec<T>> {
        let mut items = vec![item(self)?];
        while self.eat(",") {
            items.push(item(self)?);
        }
        // The whole tree stays in memory until it is checked, and most lists are short.
        items.shrink_to_fit();
        Ok(items)
    }

    /// A list in parentheses, which may be empty.
    fn in_parentheses<T>(&mut self, item: impl FnMut(&mut Self) -> Parsed<T>) -> Parsed<Vec<T>> {
        self.expect("(")?;
        if self.eat(")") {
            return Ok(Vec::new());
        }
        let items = self.list(item)?;
        if !self.eat(")") {
            return self.unexpected("`,` or `)`");
        }
        Ok(items)
    }

    /// Runs `f` one nesting level deeper, or refuses.
    fn nested<T>(&mut self, f: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth >= MAX_DEPTH {
            let message = format!("nested deeper than {MAX_DEPTH} levels");
            let error = Diagnostic::error("E0113", self.span(), message)
                .help("name the inner parts with `typedef` or `const`, or use fewer levels");
            self.report(error);
            self.stopped = true;
            self.at = self.tokens.len();
            return Err(Recover);
        }
        self.depth += 1;
        let result = f(self);
        self.depth -= 1;
        result
    }

    fn report(&mut self, diagnostic: Diagnostic) {
        if !self.stopped && self.last_error != Some(self.at) {
            self.last_error = Some(self.at);
            self.diagnostics.push(diagnostic);
        }
    }

    /// Reports a syntax error at the current token.
    fn unexpected<T>(&mut self, wanted: &str) -> Parsed<T> {
        self.refuse(self.code, wanted, None)
    }

    /// Runs `f` with another code for syntax errors.
    fn with_code<T>(&mut self, code: &'static str, f: impl FnOnce(&mut Self) -> T) -> T {
        let outer = std::mem::replace(&mut self.code, code);
        let result = f(self);
        self.code = outer;
        result
    }

    fn refuse<T>(&mut self, code: &'static str, wanted: &str, help: Option<String>) -> Parsed<T> {
        let message = format!("expected {wanted}, found {}", describe(self.kind()));
        let mut error = Diagnostic::error(code, self.span(), message);
        error.help = help;
        self.report(error);
        Err(Recover)
    }

    /// The `;` that ends a statement begun at `start`; its absence is reported and tolerated.
    // genom3.md 3.1 L6.
    fn semicolon(&mut self, start: Span) -> Parsed<()> {
        if self.eat(";") {
            return Ok(());
        }
        let found = describe(self.kind());
        let error = Diagnostic::error("E0106", self.span(), format!("expected `;`, found {found}"))
            .note(start, "the statement starts here");
        self.report(error);
        if self.is("}") || self.at_end() || self.starts_statement() { Ok(()) } else { Err(Recover) }
    }

    /// Skips to the `;` that ends a statement at brace level `level`, and records the names from
    /// token `from` on as lost.
    fn recover(&mut self, level: u32, from: usize) {
        while !self.at_end() {
            if self.braces <= level {
                if self.is(";") {
                    self.bump();
                    break;
                }
                if self.is("}") && level > 0 {
                    break;
                }
            }
            self.bump();
        }
        for token in self.tokens.get(from..self.at).unwrap_or_default() {
            if let TokenKind::Identifier(text) = &token.kind {
                self.lost.insert(text.clone());
            }
        }
    }
}

/// A token as it is named in messages.
fn describe(kind: &TokenKind) -> String {
    match kind {
        TokenKind::Identifier(text) => format!("`{text}`"),
        TokenKind::Keyword(text) | TokenKind::Punctuation(text) => format!("`{text}`"),
        TokenKind::Integer(value) => format!("`{value}`"),
        TokenKind::Float(value) => format!("`{value}`"),
        TokenKind::Fixed => "a fixed point number".to_owned(),
        TokenKind::Char(_) => "a character".to_owned(),
        TokenKind::String(_) => "a string".to_owned(),
        TokenKind::Pragma(_) => "a pragma".to_owned(),
        TokenKind::End => "end of file".to_owned(),
    }
}
