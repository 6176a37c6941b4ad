//! The preprocessor (genom3.md 1): from files to tokens, in one pass.
//!
//! Tokens go straight from a file or a macro to the lexer; there is no preprocessed text.
//! Everything is bounded: depth and number of includes, depth and size of expansions.

mod builtin;
mod condition;
mod directive;
mod expand;
mod include;
mod macros;
mod options;
mod package;
mod pragma;
mod room;
mod scanner;

pub use options::Options;

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::lex::Lexer;
use crate::model::Span;
use crate::ptoken::{Kind, PToken, Text};
use crate::source::{Files, Loaded, Memory, SourceMap};
use crate::token::Token;

use condition::Conditional;
use expand::Context;
use macros::Macro;
use room::Made;
use scanner::Scanner;

/// Reads input files, in order, as one translation unit.
///
/// Files and include chains are added to `sources`. The tokens always end with one
/// [`TokenKind::End`](crate::token::TokenKind::End), whatever happened.
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

/// Reads one text held in memory, without includes from the disk.
pub fn tokenize_text(name: &str, text: &str, sources: &mut SourceMap) -> (Vec<Token>, Diagnostics) {
    let mut files = Memory::new();
    files.insert(name, text);
    tokenize(&[PathBuf::from(name)], &Options::default(), &files, sources)
}

/// Files open at once: more means that they include each other for ever.
const MAX_INCLUDE_DEPTH: usize = 64;
/// Files opened in all.
const MAX_INCLUDES: usize = 65_536;
/// Bytes of different files, held while they are read.
const MAX_LOADED: usize = crate::source::LARGEST;
/// Bytes read in all, those of a file as often as it is included.
const MAX_BYTES: usize = 1 << 28;
/// Bytes of the paths of included files.
const MAX_PATHS: usize = 1 << 24;

struct Preprocessor<'a> {
    options: &'a Options,
    files: &'a dyn Files,
    sources: &'a mut SourceMap,
    diagnostics: Diagnostics,
    lexer: Lexer,
    /// Texts that tokens point into: those of files, and those made by `#` and `##`.
    buffers: Vec<Arc<str>>,
    /// Files being read, innermost last.
    open: Vec<Open>,
    /// Tokens to read before the file's, innermost last.
    contexts: Vec<Context>,
    macros: HashMap<Box<str>, Rc<Macro>>,
    /// First bytes of the names of macros: most identifiers are no macro and need no look-up.
    initials: [bool; 256],
    /// `-I`, then what `#pragma requires` adds.
    include_dirs: Vec<PathBuf>,
    /// Texts of files read, by identity, with their buffer.
    loaded: HashMap<PathBuf, (Loaded, u32)>,
    /// Files that said `#pragma once`.
    once: HashSet<PathBuf>,
    includes: usize,
    bytes: usize,
    /// Bytes of different files.
    held: usize,
    /// Bytes of paths.
    paths: usize,
    /// What was made of the text so far.
    made: Made,
    /// Arguments being expanded inside arguments.
    nesting: usize,
    /// While looking for a macro's arguments: the file that must not be left.
    keep_open: usize,
    /// Reading was abandoned: only `End` comes from here on.
    fatal: bool,
}

/// A file being read.
struct Open {
    scanner: Scanner,
    identity: PathBuf,
    path: PathBuf,
    conditionals: Vec<Conditional>,
}

impl<'a> Preprocessor<'a> {
    fn new(options: &'a Options, files: &'a dyn Files, sources: &'a mut SourceMap) -> Self {
        Self {
            options,
            files,
            sources,
            diagnostics: Diagnostics::default(),
            lexer: Lexer::default(),
            buffers: Vec::new(),
            open: Vec::new(),
            contexts: Vec::new(),
            macros: HashMap::new(),
            initials: [false; 256],
            include_dirs: options.include_dirs.clone(),
            loaded: HashMap::new(),
            once: HashSet::new(),
            includes: 0,
            bytes: 0,
            held: 0,
            paths: 0,
            made: Made::default(),
            nesting: 0,
            keep_open: 0,
            fatal: false,
        }
    }

    /// Reads one input file to its end.
    fn input(&mut self, path: &Path) {
        if self.fatal || !self.open_file(path, None) {
            return;
        }
        self.drain();
    }

    /// Hands everything that can be read to the lexer.
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

    /// The end of the last input file: where something is missing at the end.
    fn end_of_inputs(&self) -> Span {
        let inputs = self.sources.files().filter(|(_, file)| !file.is_synthetic());
        let last = inputs.filter(|(_, file)| file.included_from().is_none()).last();
        last.map_or_else(Span::default, |(rank, file)| {
            let end = u32::try_from(file.text().trim_end().len()).unwrap_or(u32::MAX);
            Span { file: rank, start: end, end }
        })
    }

    /// The next token with macros not yet expanded, directives obeyed.
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
                // GenoM3 passes over such a line, as over a directive that it does not know.
                Kind::Punctuation if token.first && self.text(token) == "##" => {
                    self.pass_over(token);
                }
                _ => return token,
            }
        }
    }

    fn text(&self, token: PToken) -> &str {
        self.buffers.get(token.text.buffer as usize).map_or("", |buffer| slice(buffer, token.text))
    }

    /// Adds a text that is in no file.
    fn scratch(&mut self, text: &str) -> Text {
        let buffer = u32::try_from(self.buffers.len()).unwrap_or(u32::MAX);
        self.buffers.push(text.into());
        Text { buffer, start: 0, end: u32::try_from(text.len()).unwrap_or(u32::MAX) }
    }

    /// Says an error after which going on would only make noise, and stops reading.
    fn abandon(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
        self.fatal = true;
        self.diagnostics.stopped = true;
    }
}

fn slice(buffer: &str, text: Text) -> &str {
    buffer.get(text.start as usize..text.end as usize).unwrap_or_default()
}

fn end_token(span: Span) -> PToken {
    PToken {
        kind: Kind::End,
        text: Text { buffer: 0, start: 0, end: 0 },
        span,
        space: true,
        first: true,
        frozen: false,
    }
}
