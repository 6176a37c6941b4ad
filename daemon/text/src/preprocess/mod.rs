//! The preprocessor (genom3.md 1): from files to tokens, in one pass.
//!
//! Tokens go directly from a file or a macro to the lexer; there is no preprocessed text. Depth and
//! number of includes, and depth and size of expansions, are limited.

mod builtin;
mod condition;
mod define;
mod directive;
mod expand;
mod include;
mod macros;
mod options;
mod package;
mod pragma;
mod room;
mod scanner;
mod state;

pub use builtin::GENOM;
pub use options::Options;
pub use scanner::sign_length;

use std::path::{Path, PathBuf};

use crate::diagnostic::Diagnostics;
use crate::ptoken::{Kind, PToken, Text};
use crate::source::{Files, Memory, SourceMap, Span};
use crate::token::Token;

use state::{Preprocessor, end_token, slice};

/// Reads input files, in order, as one translation unit.
///
/// Files and include chains are added to `sources`. The tokens end with exactly one
/// [`TokenKind::End`](crate::token::TokenKind::End), also after errors.
pub fn tokenize(
    inputs: &[PathBuf],
    options: &Options,
    files: &dyn Files,
    sources: &mut SourceMap,
) -> (Vec<Token>, Diagnostics) {
    let mut preprocessor = Preprocessor::new(options, files, sources);
    preprocessor.predefine();
    for input in inputs {
        preprocessor.input(input);
    }
    preprocessor.finish()
}

/// Reads one text held in memory; it cannot include files from the disk.
pub fn tokenize_text(name: &str, text: &str, sources: &mut SourceMap) -> (Vec<Token>, Diagnostics) {
    let mut files = Memory::new();
    files.insert(name, text);
    tokenize(&[PathBuf::from(name)], &Options::default(), &files, sources)
}

/// Files open at once: more means that they include each other endlessly.
const MAX_INCLUDE_DEPTH: usize = 64;
/// Files opened, in all.
const MAX_INCLUDES: usize = 65_536;
/// Bytes of the distinct files, which are all held while reading.
const MAX_LOADED: usize = crate::source::LARGEST;
/// Bytes read in all; a file counts each time it is included.
const MAX_BYTES: usize = 1 << 28;
/// Bytes of the paths of included files, in all.
const MAX_PATHS: usize = 1 << 24;

impl Preprocessor<'_> {
    /// Reads one input file to its end.
    fn input(&mut self, path: &Path) {
        if self.fatal || !self.open_file(path, None) {
            return;
        }
        self.drain();
    }

    /// Passes everything that can be read to the lexer.
    fn drain(&mut self) {
        loop {
            let token = self.expanded();
            if token.kind == Kind::End {
                return;
            }
            if !self.count_text(token) {
                return;
            }
            let buffer = self.buffers.get(token.text.buffer as usize);
            let text = buffer.map_or("", |buffer| slice(buffer, token.text));
            self.lexer.take(token, text, &mut self.diagnostics);
        }
    }

    fn finish(mut self) -> (Vec<Token>, Diagnostics) {
        let end = self.sources.files().filter(|(_, file)| !file.is_synthetic()).last();
        let end = end.map_or_else(Span::default, |(_, _)| self.end_of_inputs());
        let tokens = self.lexer.finish(end);
        (tokens, std::mem::take(&mut self.diagnostics))
    }

    /// The end of the last input file: the position of errors about something missing at the end.
    fn end_of_inputs(&self) -> Span {
        let inputs = self.sources.files().filter(|(_, file)| !file.is_synthetic());
        let last = inputs.filter(|(_, file)| file.included_from().is_none()).last();
        last.map_or_else(Span::default, |(rank, file)| {
            let end = u32::try_from(file.text().trim_end().len()).unwrap_or(u32::MAX);
            Span { file: rank, start: end, end }
        })
    }

    /// The next token before macro expansion; directives on the way are executed.
    fn raw(&mut self) -> PToken {
        while let Some(context) = self.contexts.last_mut() {
            if self.fatal {
                break;
            }
            if let Some(token) = context.next() {
                return token;
            }
            if context.barrier {
                return end_token(Span::default());
            }
            if let Some(done) = self.contexts.pop().and_then(|context| context.of) {
                done.busy.set(false);
            }
        }
        self.next_in_file()
    }

    fn next_in_file(&mut self) -> PToken {
        loop {
            if self.fatal {
                return end_token(Span::default());
            }
            let depth = self.open.len();
            let Some(open) = self.open.last_mut() else {
                return end_token(Span::default());
            };
            let token = open.scanner.next(&mut self.diagnostics);
            match token.kind {
                Kind::End if self.keep_open == depth => return token,
                Kind::End => self.close_file(),
                Kind::Punctuation if token.first && self.text(token) == "#" => {
                    self.directive(token);
                }
                // GenoM3 ignores such a line, as it does unknown directives.
                Kind::Punctuation if token.first && self.text(token) == "##" => {
                    self.pass_over(token);
                }
                _ => return token,
            }
        }
    }
}
