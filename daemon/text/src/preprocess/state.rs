//! State of the preprocessor.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;

use super::macros::Macro;
use super::options::Options;
use super::scanner::Scanner;
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::lex::Lexer;
use crate::ptoken::{Kind, PToken, Text};
use crate::source::{Files, Loaded, SourceMap, Span};

/// Reads the input files one after the other, and makes all their tokens.
pub(super) struct Preprocessor<'a> {
    pub(super) options: &'a Options,
    pub(super) files: &'a dyn Files,
    pub(super) sources: &'a mut SourceMap,
    pub(super) diagnostics: Diagnostics,
    pub(super) lexer: Lexer,
    /// Texts that tokens refer to: those of files, and those made by `#` and `##`.
    pub(super) buffers: Vec<Arc<str>>,
    /// Files being read, innermost last.
    pub(super) open: Vec<Open>,
    /// Tokens to be read before those of the file, innermost last.
    pub(super) contexts: Vec<Context>,
    pub(super) macros: HashMap<Box<str>, Rc<Macro>>,
    /// First bytes of the names of macros: most identifiers are no macro and skip the look-up.
    pub(super) initials: [bool; 256],
    /// `-I`, then what `#pragma requires` adds.
    pub(super) include_dirs: Vec<PathBuf>,
    /// Texts of the files read, by file identity, each with its buffer.
    pub(super) loaded: HashMap<PathBuf, (Loaded, u32)>,
    /// Files with `#pragma once`.
    pub(super) once: HashSet<PathBuf>,
    pub(super) includes: usize,
    pub(super) bytes: usize,
    /// Bytes of the distinct files.
    pub(super) held: usize,
    /// Bytes of the paths of included files.
    pub(super) paths: usize,
    /// Counts of what was made of the text so far.
    pub(super) made: Made,
    /// Depth of arguments being expanded inside arguments.
    pub(super) nesting: usize,
    /// While a macro's arguments are read: the file that must not be left.
    pub(super) keep_open: usize,
    /// Reading was abandoned: only `End` follows.
    pub(super) fatal: bool,
}

/// A file being read.
pub(super) struct Open {
    pub(super) scanner: Scanner,
    pub(super) identity: PathBuf,
    pub(super) path: PathBuf,
    pub(super) conditionals: Vec<Conditional>,
}

/// An open `#if`, `#ifdef` or `#ifndef`.
pub(super) struct Conditional {
    pub(super) span: Span,
    /// One of its groups was read: later ones are skipped.
    pub(super) taken: bool,
    /// `#else` was seen.
    pub(super) last: Option<Span>,
}

/// Tokens to be read before anything else.
pub(super) struct Context {
    pub(super) tokens: Vec<PToken>,
    pub(super) at: usize,
    /// The macro whose expansion this is.
    pub(super) of: Option<Rc<Macro>>,
    /// Reading stops at its end, for an argument that is expanded on its own.
    pub(super) barrier: bool,
}

impl Context {
    pub(super) fn next(&mut self) -> Option<PToken> {
        let token = self.tokens.get(self.at).copied();
        self.at += 1;
        token
    }
}

/// Counts for the limits of `room`.
#[derive(Debug, Default)]
pub(super) struct Made {
    /// Tokens that macros made, or took as arguments.
    pub(super) expanded: usize,
    /// Bytes of text that macros made.
    pub(super) bytes: usize,
    /// Tokens of definitions.
    pub(super) defined: usize,
    /// Bytes of text that went to the lexer.
    pub(super) text: usize,
}

impl<'a> Preprocessor<'a> {
    pub(super) fn new(
        options: &'a Options,
        files: &'a dyn Files,
        sources: &'a mut SourceMap,
    ) -> Self {
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

    pub(super) fn text(&self, token: PToken) -> &str {
        self.buffers.get(token.text.buffer as usize).map_or("", |buffer| slice(buffer, token.text))
    }

    /// Adds a buffer with a text that is in no file.
    pub(super) fn scratch(&mut self, text: &str) -> Text {
        let buffer = u32::try_from(self.buffers.len()).unwrap_or(u32::MAX);
        self.buffers.push(text.into());
        Text { buffer, start: 0, end: u32::try_from(text.len()).unwrap_or(u32::MAX) }
    }

    /// Reports an error after which others would only be its consequences, and stops reading.
    pub(super) fn abandon(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
        self.fatal = true;
        self.diagnostics.stopped = true;
    }
}

/// The text of a token in its buffer.
pub(super) fn slice(buffer: &str, text: Text) -> &str {
    buffer.get(text.start as usize..text.end as usize).unwrap_or_default()
}

/// The token at the end of what is read.
pub(super) fn end_token(span: Span) -> PToken {
    PToken {
        kind: Kind::End,
        text: Text { buffer: 0, start: 0, end: 0 },
        span,
        space: true,
        first: true,
        frozen: false,
    }
}
