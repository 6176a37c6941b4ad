//! Semantic highlighting: the kind of each word of a text.

use std::collections::HashMap;

use genom_description::model::Span;
use genom_description::token::TokenKind;

use super::Navigator;
use super::symbol::SymbolKind;

/// Kind of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// A keyword.
    Keyword,
    /// A number.
    Number,
    /// A string or character.
    Text,
    /// The name of a symbol.
    Name {
        /// Kind of the symbol.
        kind: SymbolKind,
        /// Whether this is its declaration.
        declaration: bool,
    },
}

impl Navigator {
    /// The words of a file with their kinds, in order. Punctuation and comments are left out, and
    /// so is what macros make, since it has no position of its own.
    #[must_use]
    pub fn paints(&self, file: u32) -> Vec<(Span, Paint)> {
        let uses = self.table.uses.iter().filter(|(span, _)| span.file == file);
        let named: HashMap<u32, usize> = uses.map(|(span, id)| (span.start, *id)).collect();
        let mut paints: Vec<(Span, Paint)> = Vec::new();
        for token in self.tokens.iter().filter(|token| token.span.file == file) {
            let span = token.span;
            let own = self.analysis.sources.expansion(span).is_none();
            let after = paints.last().is_none_or(|(last, _)| last.end <= span.start);
            if !own || !after || span.start >= span.end {
                continue;
            }
            let paint = match &token.kind {
                TokenKind::Keyword(_) => Paint::Keyword,
                TokenKind::Integer(_) | TokenKind::Float(_) | TokenKind::Fixed => Paint::Number,
                TokenKind::String(_) | TokenKind::Char(_) => Paint::Text,
                TokenKind::Identifier(word) => match named.get(&span.start) {
                    Some(id) => match self.table.get(*id) {
                        // `ids` is a keyword and the name of what it declares.
                        Some(symbol) if symbol.kind == SymbolKind::Ids => Paint::Keyword,
                        Some(symbol) => {
                            let declaration = symbol.span == span;
                            Paint::Name { kind: symbol.kind, declaration }
                        }
                        None => continue,
                    },
                    None if super::complete::is_word(word) => Paint::Keyword,
                    None => continue,
                },
                TokenKind::Punctuation(_) | TokenKind::Pragma(_) | TokenKind::End => continue,
            };
            paints.push((span, paint));
        }
        paints
    }
}
