//! Extents of declarations, derived from tokens.

use std::collections::HashMap;

use genom_description::model::Span;
use genom_description::token::{Token, TokenKind};

/// Tokens with an index by position.
pub(super) struct Extents<'a> {
    tokens: &'a [Token],
    ranks: HashMap<(u32, u32), usize>,
}

impl<'a> Extents<'a> {
    pub(super) fn new(tokens: &'a [Token]) -> Self {
        let places = tokens.iter().map(|token| (token.span.file, token.span.start));
        Extents { tokens, ranks: places.zip(0..).collect() }
    }

    fn sign(&self, rank: usize) -> &'static str {
        match self.tokens.get(rank).map(|token| &token.kind) {
            Some(TokenKind::Punctuation(sign)) => sign,
            Some(TokenKind::Pragma(_) | TokenKind::End) | None => ";",
            _ => "",
        }
    }

    fn between(&self, first: usize, last: usize, otherwise: Span) -> Span {
        match (self.tokens.get(first), self.tokens.get(last)) {
            (Some(first), Some(last)) => first.span.to(last.span),
            _ => otherwise,
        }
    }

    /// The statement that contains `name`, with its `;`.
    pub(super) fn statement(&self, name: Span) -> Span {
        let Some(&rank) = self.ranks.get(&(name.file, name.start)) else { return name };
        let mut first = rank;
        while first > 0
            && !matches!(self.sign(first - 1), ";" | "{" | "}")
            && self.tokens.get(first - 1).is_some_and(|before| before.span.file == name.file)
        {
            first -= 1;
        }
        let mut depth = 0_u32;
        let mut last = rank;
        for at in rank..self.tokens.len() {
            match self.sign(at) {
                ";" if depth == 0 => {
                    last = at;
                    break;
                }
                "{" | "(" => depth += 1,
                "}" | ")" if depth == 0 => break,
                "}" | ")" => depth -= 1,
                _ => {}
            }
            last = at;
        }
        self.between(first, last, name)
    }

    /// From the start of the statement of `name` to its name.
    pub(super) fn head(&self, name: Span) -> Span {
        Span { end: name.end, ..self.statement(name) }
    }

    /// From `first` to the `)` that closes the first `(` after `name`.
    pub(super) fn call(&self, first: Span, name: Span) -> Span {
        let Some(&rank) = self.ranks.get(&(name.file, name.start)) else { return first };
        if self.sign(rank + 1) != "(" {
            return first.to(name);
        }
        let mut depth = 0_u32;
        for at in rank + 1..self.tokens.len() {
            match self.sign(at) {
                "(" => depth += 1,
                ")" if depth <= 1 => return first.to(self.between(at, at, name)),
                ")" => depth -= 1,
                ";" if depth == 0 => break,
                _ => {}
            }
        }
        first.to(name)
    }

    /// From `first` to the separator of the next list element.
    pub(super) fn element(&self, first: Span) -> Span {
        let Some(&rank) = self.ranks.get(&(first.file, first.start)) else { return first };
        let (mut depth, mut last) = (0_u32, rank);
        for at in rank..self.tokens.len() {
            match self.sign(at) {
                "," | ")" | ";" | "}" if depth == 0 => break,
                ";" => break,
                "{" | "(" | "<" | "[" => depth += 1,
                "}" | ")" | ">" | "]" => depth = depth.saturating_sub(1),
                _ => {}
            }
            last = at;
        }
        self.between(rank, last, first)
    }
}
