//! Helpers of these tests: reading texts from memory, showing tokens briefly.

use std::path::PathBuf;

use genom_text::diagnostic::{Diagnostic, Diagnostics};
use genom_text::preprocess::{Options, tokenize};
use genom_text::source::{Memory, SourceMap};
use genom_text::token::{Pragma, Token, TokenKind};

/// The result of reading some files.
pub(crate) struct Read {
    pub(crate) tokens: Vec<Token>,
    pub(crate) diagnostics: Diagnostics,
    pub(crate) sources: SourceMap,
}

/// Reads the first of some named texts; the others may be included.
pub(crate) fn read(texts: &[(&str, &str)]) -> Read {
    read_with(texts, &Options::default())
}

pub(crate) fn read_with(texts: &[(&str, &str)], options: &Options) -> Read {
    let mut files = Memory::new();
    for (name, text) in texts {
        files.insert(*name, *text);
    }
    let mut sources = SourceMap::new();
    let inputs: Vec<PathBuf> = texts.iter().take(1).map(|(name, _)| name.into()).collect();
    let (tokens, diagnostics) = tokenize(&inputs, options, &files, &mut sources);
    Read { tokens, diagnostics, sources }
}

impl Read {
    /// The tokens, separated by blanks.
    pub(crate) fn tokens(&self) -> String {
        let shown: Vec<_> = self.tokens.iter().map(|token| show(&token.kind)).collect();
        shown.join(" ").trim_end().to_owned()
    }

    /// The messages, one a line: `file:line:col: code message`.
    pub(crate) fn messages(&self) -> String {
        let line = |diagnostic: &Diagnostic| {
            let place = self.sources.location(diagnostic.span);
            let (file, line, column) = (place.basename(), place.line, place.column);
            format!("{file}:{line}:{column}: {} {}\n", diagnostic.code, diagnostic.message)
        };
        self.diagnostics.iter().map(line).collect()
    }
}

fn show(kind: &TokenKind) -> String {
    let words = |arguments: &[(Box<str>, _)]| {
        let words: Vec<_> = arguments.iter().map(|(word, _)| format!("<{word}>")).collect();
        words.join(" ")
    };
    match kind {
        TokenKind::Identifier(name) => name.to_string(),
        TokenKind::Keyword(name) => name.to_uppercase(),
        TokenKind::Integer(value) => value.to_string(),
        TokenKind::Float(value) => format!("{value:?}"),
        TokenKind::Fixed => "fixed!".to_owned(),
        TokenKind::Char(code) => format!("'{code}'"),
        TokenKind::String(text) => format!("{text:?}"),
        TokenKind::Punctuation(sign) => (*sign).to_owned(),
        TokenKind::Pragma(pragma) => match &**pragma {
            Pragma::Requires(list) => format!("#requires {}", words(list)),
            Pragma::Provides(list) => format!("#provides {}", words(list)),
            Pragma::Masquerade(list) => format!("#masquerade {}", words(list)),
        },
        TokenKind::End => String::new(),
    }
}
