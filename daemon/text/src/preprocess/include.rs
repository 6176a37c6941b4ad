//! Opening and closing of files: inputs and `#include` (genom3.md 1.2).

use std::io;
use std::path::{Path, PathBuf};

use super::scanner::Scanner;
use super::state::Open;
use super::{
    Kind, MAX_BYTES, MAX_INCLUDE_DEPTH, MAX_INCLUDES, MAX_LOADED, MAX_PATHS, PToken, Preprocessor,
};
use crate::diagnostic::Diagnostic;
use crate::source::Span;
use crate::source::{Encoding, Loaded};

impl Preprocessor<'_> {
    /// `#include`; `line` is what follows the word.
    pub(super) fn include(&mut self, directive: PToken, line: &[PToken]) {
        let Some((name, quoted, span)) = self.include_name(directive, line) else { return };
        let Some(path) = self.search(&name, quoted) else {
            self.not_found(&name, quoted, span);
            return;
        };
        let identity = self.files.identity(&path);
        if self.once.contains(&identity) {
            return;
        }
        if self.open.len() >= MAX_INCLUDE_DEPTH {
            self.too_deep(&identity, span);
            return;
        }
        self.open_file(&path, Some(span));
    }

    /// The name between quotes or angle brackets; macros are expanded if it begins with neither.
    fn include_name(&mut self, directive: PToken, line: &[PToken]) -> Option<(String, bool, Span)> {
        let mut expanded = Vec::new();
        let direct = |first: Option<&PToken>, this: &Self| {
            first.is_some_and(|token| {
                token.kind == Kind::String || this.text(*token).starts_with('<')
            })
        };
        let mut tokens = line;
        if !direct(line.first(), self) {
            expanded.extend(self.expand_list(line.to_vec()));
            tokens = &expanded;
        }
        let first = tokens.first().copied();
        match first {
            Some(token) if token.kind == Kind::String => {
                let text = self.text(token).trim_matches('"').to_owned();
                if !text.is_empty() {
                    return Some((text, true, token.span));
                }
            }
            Some(token) if self.text(token).starts_with('<') => {
                let close = tokens.iter().position(|token| self.text(*token).starts_with('>'));
                let inside = close.and_then(|close| tokens.get(1..close)).unwrap_or_default();
                let mut name = self.text(token).get(1..).unwrap_or_default().to_owned();
                for (rank, part) in inside.iter().enumerate() {
                    if part.space && rank > 0 {
                        name.push(' ');
                    }
                    name.push_str(self.text(*part));
                }
                if let Some(close) = close.and_then(|close| tokens.get(close))
                    && !name.is_empty()
                {
                    return Some((name, false, join(token.span, close.span)));
                }
            }
            _ => {}
        }
        let span = first.map_or(directive.span, |token| token.span);
        self.diagnostics.push(
            Diagnostic::error("E0123", span, "`#include` must name a file")
                .help("write `#include \"file.gen\"` or `#include <dir/file.gen>`"),
        );
        None
    }

    /// Finds a file: `"f"` beside the including file, then as `<f>`; `<f>` on the include path in
    /// order.
    fn search(&self, name: &str, quoted: bool) -> Option<PathBuf> {
        let absolute = Path::new(name).is_absolute().then(|| PathBuf::from(name));
        let beside = self.open.last().filter(|_| quoted).map(|open| {
            open.path.parent().map_or_else(|| PathBuf::from(name), |parent| parent.join(name))
        });
        let on_path = self.include_dirs.iter().map(|dir| dir.join(name));
        absolute.into_iter().chain(beside).chain(on_path).find(|path| self.files.is_file(path))
    }

    fn not_found(&mut self, name: &str, quoted: bool, span: Span) {
        let dirs: Vec<_> = self.include_dirs.iter().map(|dir| dir.display().to_string()).collect();
        let mut looked = Vec::new();
        if quoted {
            looked.push("beside the including file".to_owned());
        }
        looked.extend(dirs);
        let help = if looked.is_empty() {
            "name its directory with `-I DIR`: there is no default include path".to_owned()
        } else {
            format!("looked {}; add a directory with `-I DIR`", looked.join(", "))
        };
        self.diagnostics
            .push(Diagnostic::error("E0121", span, format!("cannot find `{name}`")).help(help));
    }

    fn too_deep(&mut self, identity: &Path, span: Span) {
        let again = self.open.iter().rposition(|open| open.identity == identity);
        let message = match again {
            Some(rank) => {
                let cycle = self.open.iter().skip(rank).map(|open| base(&open.path));
                let cycle: Vec<_> = cycle.chain([base(identity)]).collect();
                format!("files include each other without end: {}", cycle.join(" -> "))
            }
            None => format!("`#include` is nested more than {MAX_INCLUDE_DEPTH} deep"),
        };
        self.abandon(
            Diagnostic::error("E0122", span, message)
                .help("write `#pragma once` at the top of a file that may be reached twice"),
        );
    }

    /// Opens a file on top of those being read; false when it cannot be read.
    pub(super) fn open_file(&mut self, path: &Path, from: Option<Span>) -> bool {
        self.includes += 1;
        self.paths += path.as_os_str().len();
        if self.includes > MAX_INCLUDES || self.paths > MAX_PATHS {
            let message = if self.includes > MAX_INCLUDES {
                format!("more than {MAX_INCLUDES} files are included")
            } else {
                format!("the paths of included files take more than {} MiB", MAX_PATHS >> 20)
            };
            self.abandon(Diagnostic::error("E0122", from.unwrap_or_default(), message));
            return false;
        }
        let identity = self.files.identity(path);
        let Some((loaded, buffer)) = self.load(path, &identity, from) else { return false };
        self.bytes += loaded.text.len();
        if self.bytes > MAX_BYTES {
            let message = format!(
                "the files are larger than {} MiB, each as often as it is included",
                MAX_BYTES >> 20
            );
            self.abandon(Diagnostic::error("E0133", from.unwrap_or_default(), message));
            return false;
        }
        let rank = self.sources.add(path.to_owned(), &loaded, from);
        if loaded.encoding == Encoding::Latin1 {
            let message = format!("`{}` is not UTF-8; it is read as Latin-1", base(path));
            let first = loaded.text.find(|c: char| !c.is_ascii()).unwrap_or(0);
            let start = u32::try_from(first).unwrap_or(u32::MAX);
            let span = Span { file: rank, start, end: start + 2 };
            self.diagnostics
                .push(Diagnostic::warning("W0104", span, message).help("save the file as UTF-8"));
        }
        let scanner = Scanner::new(loaded.logical, rank, buffer);
        let path = path.to_owned();
        self.open.push(Open { scanner, identity, path, conditionals: Vec::new() });
        true
    }

    fn load(&mut self, path: &Path, identity: &Path, from: Option<Span>) -> Option<(Loaded, u32)> {
        if let Some(known) = self.loaded.get(identity) {
            return Some(known.clone());
        }
        match self.files.read(path) {
            Ok(bytes) if self.held + bytes.len() > MAX_LOADED => {
                let message = format!("the files are larger than {} MiB in all", MAX_LOADED >> 20);
                self.unreadable(path, from, "E0133", message);
                self.fatal = true;
                self.diagnostics.stopped = true;
                None
            }
            Ok(bytes) => {
                self.held += bytes.len();
                let loaded = Loaded::new(bytes);
                let buffer = u32::try_from(self.buffers.len()).unwrap_or(u32::MAX);
                self.buffers.push(loaded.logical.text.clone());
                self.loaded.insert(identity.to_owned(), (loaded.clone(), buffer));
                Some((loaded, buffer))
            }
            Err(error) => {
                let why = match error.kind() {
                    io::ErrorKind::NotFound => "there is no such file".to_owned(),
                    _ => error.to_string(),
                };
                let large = error.kind() == io::ErrorKind::FileTooLarge;
                let code = if large { "E0133" } else { "E0120" };
                let message = format!("cannot read `{}`: {why}", path.display());
                self.unreadable(path, from, code, message);
                None
            }
        }
    }

    /// Reports an input that cannot be read. It is added as an empty file, so that the message has
    /// a position.
    fn unreadable(&mut self, path: &Path, from: Option<Span>, code: &'static str, message: String) {
        let span = from.unwrap_or_else(|| {
            let file = self.sources.add(path.to_owned(), &Loaded::new(Vec::new()), None);
            Span { file, start: 0, end: 0 }
        });
        self.diagnostics.push(Diagnostic::error(code, span, message));
    }

    /// Leaves the innermost file.
    pub(super) fn close_file(&mut self) {
        let Some(open) = self.open.pop() else { return };
        for conditional in open.conditionals {
            self.diagnostics.push(
                Diagnostic::error("E0129", conditional.span, "this condition is never closed")
                    .help("close it with `#endif` in the same file"),
            );
        }
    }
}

fn base(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// From the beginning of one span to the end of another, when they are in one file.
pub(super) fn join(first: Span, last: Span) -> Span {
    if first.file == last.file && last.end >= first.start {
        Span { end: last.end, ..first }
    } else {
        first
    }
}
