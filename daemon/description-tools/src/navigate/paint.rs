//! What each word of a text is: for editors that colour by meaning.

use std::collections::HashMap;

use genom_description::model::Span;
use genom_description::token::TokenKind;

use super::Navigator;
use super::symbol::SymbolKind;

/// What a word is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// A word of the language.
    Keyword,
    /// A number.
    Number,
    /// A text or a character.
    Text,
    /// A name of something declared, here or elsewhere.
    Name {
        /// What it names.
        kind: SymbolKind,
        /// Whether it is declared here.
        declaration: bool,
    },
}

impl Navigator {
    /// The words of a file that mean something, in order. Signs and comments are left out, and
    /// what macros make has no place of its own.
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
                        // `ids` is a word that stands for what it declares.
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
