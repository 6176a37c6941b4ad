//! Order, deduplication and number of the diagnostics that are shown.

use std::collections::HashSet;
use std::path::Path;

use super::{Diagnostic, Diagnostics, Severity};
use crate::source::SourceMap;
use crate::source::Span;

/// Diagnostics in the order in which the text is read, each once.
///
/// Those of an included file come at the position of its `#include`. A file without guard that is
/// included twice repeats its mistakes: they are shown once.
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

/// Sort key of a position: its input file, then an offset in each file on the include chain.
fn reading_order(span: Span, sources: &SourceMap) -> Vec<u32> {
    let mut places = vec![span];
    places.extend(sources.include_chain(span));
    let root = places.last().map_or(span.file, |place| place.file);
    std::iter::once(root).chain(places.iter().rev().map(|place| place.start)).collect()
}

/// How many diagnostics are not shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Rest {
    /// Errors that are not shown.
    pub errors: usize,
    /// Warnings that are not shown.
    pub warnings: usize,
    /// Hints that are not shown.
    pub hints: usize,
}

impl Rest {
    /// Whether all diagnostics are shown.
    #[must_use]
    pub fn is_empty(self) -> bool {
        self == Self::default()
    }
}

/// `... and 3 errors, 1 warning more`.
impl std::fmt::Display for Rest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        let all = [(self.errors, "error"), (self.warnings, "warning"), (self.hints, "hint")];
        let said = all.iter().filter(|(count, _)| *count > 0);
        let said = said.map(|(count, what)| format!("{count} {what}{}", plural(*count)));
        write!(f, "... and {} more", said.collect::<Vec<_>>().join(", "))
    }
}

/// The first diagnostics in the order in which the text is read, and how many more there are.
#[must_use]
pub fn first(
    diagnostics: &Diagnostics,
    sources: &SourceMap,
    most: usize,
) -> (Vec<Diagnostic>, Rest) {
    let all = ordered(diagnostics, sources);
    let (shown, left) = all.split_at(most.min(all.len()));
    let count = |all: &mut dyn Iterator<Item = &Diagnostic>, severity| {
        all.filter(|said| said.severity == severity).count()
    };
    let kept = |severity| count(&mut diagnostics.iter(), severity);
    let left = |severity| count(&mut left.iter().copied(), severity);
    let rest = Rest {
        errors: left(Severity::Error) + diagnostics.errors() - kept(Severity::Error),
        warnings: left(Severity::Warning) + diagnostics.warnings() - kept(Severity::Warning),
        hints: left(Severity::Hint) + diagnostics.hints() - kept(Severity::Hint),
    };
    (shown.iter().map(|said| (*said).clone()).collect(), rest)
}
