//! Converts between positions of editors (URIs, lines, UTF-16 units) and ours (paths, bytes).

use std::ffi::OsString;
use std::os::unix::ffi::{OsStrExt as _, OsStringExt as _};
use std::path::{Path, PathBuf};

use genom_description::model::Span;
use genom_description::source::{SourceFile, SourceMap, tidy};
use lsp_types::{Location, Position, Range, Uri};

/// The path of a `file:` URI.
pub(super) fn path_of(uri: &Uri) -> Option<PathBuf> {
    let rest = uri.as_str().strip_prefix("file://")?;
    // A host name may precede the path; only files of this machine can be read.
    let rest = rest.strip_prefix("localhost").unwrap_or(rest);
    let mut bytes = Vec::with_capacity(rest.len());
    let mut left = rest.bytes();
    while let Some(byte) = left.next() {
        if byte == b'%' {
            let digits = [left.next()?, left.next()?];
            bytes.push(u8::from_str_radix(std::str::from_utf8(&digits).ok()?, 16).ok()?);
        } else {
            bytes.push(byte);
        }
    }
    Some(PathBuf::from(OsString::from_vec(bytes)))
}

/// The `file:` URI of an absolute path.
pub(super) fn uri_of(path: &Path) -> Option<Uri> {
    let mut text = "file://".to_owned();
    for byte in path.as_os_str().as_bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'-' | b'.' | b'_' | b'~' => {
                text.push(char::from(*byte));
            }
            other => text.push_str(&format!("%{other:02X}")),
        }
    }
    text.parse().ok()
}

/// The byte offset of a position; the end of the line if the position is beyond it.
pub(super) fn offset(file: &SourceFile, position: Position) -> u32 {
    let start = file.line_start(position.line.saturating_add(1));
    let rest = file.text().get(start as usize..).unwrap_or_default();
    let line = rest.split(['\n', '\r']).next().unwrap_or_default();
    let mut units = 0;
    let mut at = 0;
    for c in line.chars() {
        if units >= position.character as usize {
            break;
        }
        units += c.len_utf16();
        at += c.len_utf8();
    }
    start + u32::try_from(at).unwrap_or_default()
}

/// The position of a byte offset.
pub(super) fn position(file: &SourceFile, offset: u32) -> Position {
    let (line, _) = file.line_column(offset);
    let start = file.line_start(line) as usize;
    let before = file.text().get(start..offset as usize).unwrap_or_default();
    let units = before.encode_utf16().count();
    Position::new(line - 1, u32::try_from(units).unwrap_or(u32::MAX))
}

/// The range of a span.
pub(super) fn range(file: &SourceFile, span: Span) -> Range {
    Range::new(position(file, span.start), position(file, span.end))
}

/// A span as a location for the editor; `None` if it is in no file.
pub(super) fn location(sources: &SourceMap, span: Span) -> Option<Location> {
    let file = sources.file(span.file).filter(|file| !file.is_synthetic())?;
    Some(Location::new(uri_of(&tidy(file.path()))?, range(file, span)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_uris_are_two_ways_to_say_one_thing() {
        for path in ["/a/b.gen", "/a b/\u{e9}%.gen", "/c++/x.gen"] {
            let uri = uri_of(Path::new(path)).unwrap();
            assert_eq!(path_of(&uri).unwrap(), Path::new(path), "{}", uri.as_str());
        }
        let other: Uri = "untitled:x".parse().unwrap();
        assert_eq!(path_of(&other), None);
    }

    #[test]
    fn columns_count_utf_16_units() {
        let text = "// \u{1f916}\u{e9}x\r\ny\n";
        let analysis = genom_description::read_text("a.gen", text, &Default::default());
        let (_, file) =
            analysis.sources.files().find(|(_, f)| f.path() == Path::new("a.gen")).unwrap();
        let x = u32::try_from(text.find('x').unwrap()).unwrap();
        assert_eq!(position(file, x), Position::new(0, 6));
        assert_eq!(offset(file, Position::new(0, 6)), x);
        assert_eq!(offset(file, Position::new(0, 99)), x + 1, "not into the next line");
        let y = u32::try_from(text.find('y').unwrap()).unwrap();
        assert_eq!(offset(file, Position::new(1, 0)), y);
        assert_eq!(offset(file, Position::new(99, 0)), u32::try_from(text.len()).unwrap());
    }
}
