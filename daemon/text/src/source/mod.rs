//! Every file read, how it was included, and the line and column of each byte.
//!
//! A file that is included twice has two entries, each with its own include chain; they share the
//! text.

mod decode;
mod files;
mod span;

pub use decode::{Encoding, decode};
pub use files::{Disk, Files, Memory, check_file, tidy};
pub use span::Span;

pub(crate) use decode::Logical;
pub(crate) use files::LARGEST;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// All files of a specification, by index.
#[derive(Debug, Default)]
pub struct SourceMap {
    files: Vec<SourceFile>,
    /// Macros used directly in a file, by the position of the use.
    expansions: HashMap<Span, Expansion>,
}

/// One occurrence of a file in the translation unit.
#[derive(Clone, Debug)]
pub struct SourceFile {
    path: PathBuf,
    text: Arc<str>,
    encoding: Encoding,
    lines: Arc<[u32]>,
    included_from: Option<Span>,
    marks: Vec<LineMark>,
    synthetic: bool,
}

/// The text of a file, shared by all its inclusions.
#[derive(Clone, Debug)]
pub(crate) struct Loaded {
    pub(crate) text: Arc<str>,
    pub(crate) encoding: Encoding,
    pub(crate) logical: Logical,
    lines: Arc<[u32]>,
}

impl Loaded {
    pub(crate) fn new(bytes: Vec<u8>) -> Self {
        let (text, encoding) = decode(bytes);
        let logical = Logical::new(&text);
        let lines = line_starts(&text);
        Self { text, encoding, logical, lines }
    }
}

/// A `#line` directive, effective from a byte offset on.
#[derive(Clone, Debug)]
struct LineMark {
    offset: u32,
    line: u32,
    name: Option<PathBuf>,
}

/// The macro that made the tokens at a position.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Expansion {
    /// Name of the macro.
    pub name: String,
    /// Where it is defined.
    pub definition: Span,
}

/// A position as it is shown to people.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location<'a> {
    /// Path of the file, as it was reached or as `#line` gave it.
    pub path: &'a Path,
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1, in characters.
    pub column: u32,
}

impl Location<'_> {
    /// Last component of the path, as GenoM3 prints it (genom3.md 1.4).
    #[must_use]
    pub fn basename(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }
}

impl SourceMap {
    /// A map without files.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The file with an index; `None` for a span of another map.
    #[must_use]
    pub fn file(&self, rank: u32) -> Option<&SourceFile> {
        self.files.get(rank as usize)
    }

    /// Every occurrence of a file, with its index.
    pub fn files(&self) -> impl Iterator<Item = (u32, &SourceFile)> {
        (0u32..).zip(&self.files)
    }

    /// Where a span begins, `#line` applied.
    #[must_use]
    pub fn location(&self, span: Span) -> Location<'_> {
        self.place(span.file, span.start)
    }

    /// Where a span ends (one past its last character), `#line` applied.
    #[must_use]
    pub fn end_location(&self, span: Span) -> Location<'_> {
        self.place(span.file, span.end)
    }

    /// The text of a span, empty for a span of another map.
    #[must_use]
    pub fn text(&self, span: Span) -> &str {
        self.file(span.file)
            .and_then(|file| file.text.get(span.start as usize..span.end as usize))
            .unwrap_or_default()
    }

    /// Positions of the `#include`s that lead to the file of `span`, innermost first.
    pub fn include_chain(&self, span: Span) -> impl Iterator<Item = Span> {
        let from = |span: &Span| self.file(span.file).and_then(|file| file.included_from);
        std::iter::successors(from(&span), move |span| from(span))
    }

    /// The macro that made the tokens at exactly this position, if one did.
    #[must_use]
    pub fn expansion(&self, span: Span) -> Option<&Expansion> {
        self.expansions.get(&span)
    }

    /// Adds a text that was not read from a file, such as the command line's definitions.
    pub(crate) fn add_synthetic(&mut self, name: &str, text: &str) -> u32 {
        let rank = self.add(PathBuf::from(name), &Loaded::new(text.into()), None);
        if let Some(file) = self.files.last_mut() {
            file.synthetic = true;
        }
        rank
    }

    /// Adds an occurrence of a file.
    pub(crate) fn add(
        &mut self,
        path: PathBuf,
        loaded: &Loaded,
        included_from: Option<Span>,
    ) -> u32 {
        let rank = u32::try_from(self.files.len()).unwrap_or(u32::MAX);
        self.files.push(SourceFile {
            path,
            text: Arc::clone(&loaded.text),
            encoding: loaded.encoding,
            lines: Arc::clone(&loaded.lines),
            included_from,
            marks: Vec::new(),
            synthetic: false,
        });
        rank
    }

    /// Records a `#line`: from byte `offset` of a file, lines count from `line`.
    pub(crate) fn mark_line(&mut self, span: Span, line: u32, name: Option<PathBuf>) {
        if let Some(file) = self.files.get_mut(span.file as usize) {
            let name = name.or_else(|| file.marks.last().and_then(|mark| mark.name.clone()));
            let next = file.lines.partition_point(|start| *start <= span.start);
            let end = u32::try_from(file.text.len()).unwrap_or(u32::MAX);
            let offset = file.lines.get(next).copied().unwrap_or(end);
            // Some preprocessors write `# 0 "file"`; lines count from 1.
            file.marks.push(LineMark { offset, line: line.max(1), name });
        }
    }

    /// Marks the files of this name as text that is in no file of the user.
    pub fn mark_synthetic(&mut self, name: &str) {
        for file in self.files.iter_mut().filter(|file| file.path == Path::new(name)) {
            file.synthetic = true;
        }
    }

    pub(crate) fn record_expansion(&mut self, place: Span, name: &str, definition: Span) {
        self.expansions
            .entry(place)
            .or_insert_with(|| Expansion { name: name.to_owned(), definition });
    }

    fn place(&self, rank: u32, offset: u32) -> Location<'_> {
        let Some(file) = self.file(rank) else {
            return Location { path: Path::new("?"), line: 1, column: 1 };
        };
        let (line, column) = file.line_column(offset);
        let marks = file.marks.partition_point(|mark| mark.offset <= offset);
        match marks.checked_sub(1).and_then(|last| file.marks.get(last)) {
            None => Location { path: &file.path, line, column },
            Some(mark) => Location {
                path: mark.name.as_deref().unwrap_or(&file.path),
                line: mark.line.saturating_add(line - file.line_column(mark.offset).0),
                column,
            },
        }
    }
}

impl SourceFile {
    /// Path, as the file was reached.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Decoded text; spans are byte offsets into it.
    #[must_use]
    pub fn text(&self) -> &Arc<str> {
        &self.text
    }

    /// Encoding of the file on the disk.
    #[must_use]
    pub fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Position of the `#include` that opened it; `None` for an input file.
    #[must_use]
    pub fn included_from(&self) -> Option<Span> {
        self.included_from
    }

    /// Whether it is not a file of the user but generated text (predefined macros, `-D`).
    #[must_use]
    pub fn is_synthetic(&self) -> bool {
        self.synthetic
    }

    /// Line and column of a byte in the file itself, both from 1; `#line` is not applied.
    #[must_use]
    pub fn line_column(&self, offset: u32) -> (u32, u32) {
        let line = self.lines.partition_point(|start| *start <= offset).max(1);
        let start = self.lines.get(line - 1).copied().unwrap_or(0) as usize;
        let end = (offset as usize).min(self.text.len());
        let before = self.text.as_bytes().get(start..end).unwrap_or_default();
        // UTF-8 continuation bytes are not counted; a column past the end is that of the end.
        let column = 1 + before.iter().filter(|byte| **byte & 0xc0 != 0x80).count();
        (u32::try_from(line).unwrap_or(u32::MAX), u32::try_from(column).unwrap_or(u32::MAX))
    }

    /// Offset of the first byte of a line, counted from 1; the end of the text past the last line.
    #[must_use]
    pub fn line_start(&self, line: u32) -> u32 {
        let end = u32::try_from(self.text.len()).unwrap_or(u32::MAX);
        self.lines.get(line.saturating_sub(1) as usize).copied().unwrap_or(end)
    }

    /// Number of lines.
    #[must_use]
    pub fn line_count(&self) -> u32 {
        u32::try_from(self.lines.len()).unwrap_or(u32::MAX)
    }
}

fn line_starts(text: &str) -> Arc<[u32]> {
    let newlines = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
    let starts = newlines.map(|(at, _)| u32::try_from(at + 1).unwrap_or(u32::MAX));
    std::iter::once(0).chain(starts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loaded(text: &str) -> Loaded {
        Loaded::new(text.into())
    }

    #[test]
    fn a_byte_has_a_line_and_a_column_in_characters() {
        let mut map = SourceMap::new();
        let file = map.add("d/a.gen".into(), &loaded("\u{e9}a\nbc\n"), None);
        let at = |start| {
            let place = map.location(Span { file, start, end: start });
            (place.line, place.column)
        };
        assert_eq!(at(0), (1, 1));
        assert_eq!(at(2), (1, 2));
        assert_eq!(at(4), (2, 1));
        assert_eq!(at(5), (2, 2));
        assert_eq!(at(99), (3, 1));
        assert_eq!(map.location(Span { file, start: 0, end: 0 }).basename(), "a.gen");
    }

    #[test]
    fn line_directives_move_what_follows_only() {
        let mut map = SourceMap::new();
        let file = map.add("a.gen".into(), &loaded("x\n#line 40 \"b\"\ny\nz\n"), None);
        map.mark_line(Span { file, start: 2, end: 3 }, 40, Some("b".into()));
        let at = |start| {
            let place = map.location(Span { file, start, end: start });
            (place.basename(), place.line)
        };
        assert_eq!(at(0), ("a.gen".to_owned(), 1));
        assert_eq!(at(15), ("b".to_owned(), 40));
        assert_eq!(at(17), ("b".to_owned(), 41));
    }
}
