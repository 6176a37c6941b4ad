//! Collecting diagnostics: all are counted, the first ones are kept.

use std::ops::{Deref, DerefMut};

use super::{Diagnostic, Severity};

/// Errors that are kept, and warnings, and hints; more are only counted, since a text may have
/// millions.
const KEPT: usize = 10_000;

/// Errors, warnings and hints of a description.
///
/// Dereferences to those that are kept; [`Diagnostics::errors`] and [`Diagnostics::warnings`] count
/// all.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    kept: Vec<Diagnostic>,
    errors: Tally,
    warnings: Tally,
    hints: Tally,
    /// Reading was abandoned at an error, so that errors about missing names would mislead.
    pub stopped: bool,
}

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    found: usize,
    kept: usize,
}

impl Diagnostics {
    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let tally = self.tally(diagnostic.severity);
        tally.found += 1;
        if tally.kept < KEPT {
            tally.kept += 1;
            self.kept.push(diagnostic);
        }
    }

    /// Adds those of another list after these.
    pub fn append(&mut self, other: Diagnostics) {
        let (errors, warnings, hints) = (other.errors, other.warnings, other.hints);
        for diagnostic in other.kept {
            self.push(diagnostic);
        }
        self.stopped |= other.stopped;
        self.errors.found += errors.found - errors.kept;
        self.warnings.found += warnings.found - warnings.kept;
        self.hints.found += hints.found - hints.kept;
    }

    /// How many errors were found.
    #[must_use]
    pub fn errors(&self) -> usize {
        self.errors.found
    }

    /// How many warnings were found.
    #[must_use]
    pub fn warnings(&self) -> usize {
        self.warnings.found
    }

    /// How many hints were found.
    #[must_use]
    pub fn hints(&self) -> usize {
        self.hints.found
    }

    /// How many were found in all.
    #[must_use]
    pub fn found(&self) -> usize {
        self.errors.found + self.warnings.found + self.hints.found
    }

    /// Drops those kept for which `keep` returns false.
    pub fn retain(&mut self, keep: impl Fn(&Diagnostic) -> bool) {
        for said in std::mem::take(&mut self.kept) {
            if keep(&said) {
                self.kept.push(said);
            } else {
                let tally = self.tally(said.severity);
                tally.kept -= 1;
                tally.found -= 1;
            }
        }
    }

    /// Sorts by position; those at one position keep their order.
    pub fn sort_by_place(&mut self) {
        self.kept.sort_by_key(|said| (said.span.file, said.span.start));
    }

    fn tally(&mut self, severity: Severity) -> &mut Tally {
        match severity {
            Severity::Error => &mut self.errors,
            Severity::Warning => &mut self.warnings,
            Severity::Hint => &mut self.hints,
        }
    }
}

impl Deref for Diagnostics {
    type Target = [Diagnostic];

    fn deref(&self) -> &[Diagnostic] {
        &self.kept
    }
}

impl DerefMut for Diagnostics {
    fn deref_mut(&mut self) -> &mut [Diagnostic] {
        &mut self.kept
    }
}

impl Extend<Diagnostic> for Diagnostics {
    fn extend<I: IntoIterator<Item = Diagnostic>>(&mut self, all: I) {
        all.into_iter().for_each(|one| self.push(one));
    }
}

impl FromIterator<Diagnostic> for Diagnostics {
    fn from_iter<I: IntoIterator<Item = Diagnostic>>(all: I) -> Self {
        let mut list = Self::default();
        list.extend(all);
        list
    }
}

impl<'d> IntoIterator for &'d Diagnostics {
    type Item = &'d Diagnostic;
    type IntoIter = std::slice::Iter<'d, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.kept.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Span;

    #[test]
    fn all_are_counted_and_no_flood_of_warnings_hides_an_error() {
        let mut list = Diagnostics::default();
        list.extend((0..KEPT + 5).map(|_| Diagnostic::warning("W0101", Span::default(), "w")));
        list.push(Diagnostic::error("E0101", Span::default(), "e"));
        assert_eq!((list.errors(), list.warnings(), list.len()), (1, KEPT + 5, KEPT + 1));
        let mut all = Diagnostics::default();
        all.append(list.clone());
        all.append(list);
        assert_eq!((all.errors(), all.warnings(), all.len()), (2, 2 * (KEPT + 5), KEPT + 2));
    }
}
