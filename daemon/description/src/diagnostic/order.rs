//! The order in which diagnostics are shown, without echoes.

use std::collections::HashSet;
use std::path::Path;

use super::Diagnostic;
use crate::model::Span;
use crate::source::SourceMap;

/// Diagnostics in the order in which the text is read, each once.
///
/// What is said of an included file comes where the file is included.
/// A file without guard that is included twice repeats its mistakes: they are shown once.
#[must_use]
pub fn ordered<'d>(diagnostics: &'d [Diagnostic], sources: &SourceMap) -> Vec<&'d Diagnostic> {
    let mut sorted: Vec<_> = diagnostics.iter().collect();
    sorted.sort_by_cached_key(|d| reading_order(d.span, sources));
    let mut said = HashSet::new();
    sorted.retain(|d| {
        let path = sources.file(d.span.file).map_or(Path::new(""), |file| file.path());
        said.insert((path, d.span.start, d.span.end, d.code, &d.message))
    });
    sorted
}

/// The places to pass on the way to a span: its input file, then an offset per file.
fn reading_order(span: Span, sources: &SourceMap) -> Vec<u32> {
    let mut places = vec![span];
    places.extend(sources.include_chain(span));
    let root = places.last().map_or(span.file, |place| place.file);
    std::iter::once(root).chain(places.iter().rev().map(|place| place.start)).collect()
}
