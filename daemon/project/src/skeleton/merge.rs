//! Existing sources are brought up to date with a description that has changed: missing functions
//! are added at the end, nothing is taken away, and functions whose parameters differ are reported.

use std::ops::Range;
use std::path::PathBuf;

use crate::c_source::{Function, functions, parameters};

use super::{Sheet, Wanted};

/// An existing source.
#[derive(Clone, Debug)]
pub struct Source {
    /// Its place below the project's directory.
    pub path: PathBuf,
    /// What it contains.
    pub text: String,
}

/// A function whose declaration differs from the description's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Conflict {
    /// Its name.
    pub name: String,
    /// The source that defines it.
    pub path: PathBuf,
    /// Its line there.
    pub line: usize,
    /// Bytes of its declaration there.
    pub place: Range<usize>,
    /// The declaration there.
    pub found: String,
    /// The declaration that the description asks for.
    pub wanted: String,
}

/// The result for all sources.
#[derive(Clone, Debug, Default)]
pub struct Merge {
    /// Sources that are new or have new functions, with all their text.
    pub changed: Vec<Source>,
    /// Functions that were added, with their source.
    pub added: Vec<(String, PathBuf)>,
    /// Functions whose declaration differs.
    pub conflicts: Vec<Conflict>,
}

/// Compares `sheets` with the existing sources, in whichever of which a function is defined.
#[must_use]
pub fn merge(sheets: &[Sheet], sources: &[Source]) -> Merge {
    let defined: Vec<(&Source, Vec<Function>)> =
        sources.iter().map(|source| (source, functions(&source.text))).collect();
    let find = |wanted: &Wanted| {
        defined.iter().find_map(|(source, list)| {
            Some((*source, list.iter().find(|function| function.name == wanted.name)?))
        })
    };
    let mut result = Merge::default();
    for sheet in sheets {
        let mut missing = Vec::new();
        for wanted in &sheet.functions {
            match find(wanted) {
                None => missing.push(wanted),
                Some((source, function)) => {
                    if function.parameters != parameters(&wanted.declaration) {
                        result.conflicts.push(conflict(source, function, wanted));
                    }
                }
            }
        }
        let existing = sources.iter().find(|source| source.path == sheet.path);
        let mut text = existing.map_or_else(|| sheet.opening.clone(), |found| found.text.clone());
        for wanted in &missing {
            if !text.ends_with('\n') {
                text.push('\n');
            }
            text.push('\n');
            text.push_str(&wanted.text);
            result.added.push((wanted.name.clone(), sheet.path.clone()));
        }
        if !missing.is_empty() {
            result.changed.push(Source { path: sheet.path.clone(), text });
        }
    }
    result
}

fn conflict(source: &Source, function: &Function, wanted: &Wanted) -> Conflict {
    let place = function.declaration.clone();
    let before = source.text.get(..place.start).unwrap_or_default();
    Conflict {
        name: function.name.clone(),
        path: source.path.clone(),
        line: before.matches('\n').count() + 1,
        found: source.text.get(place.clone()).unwrap_or_default().to_owned(),
        wanted: wanted.declaration.clone(),
        place,
    }
}

impl Merge {
    /// The text of a source with the conflicts in it settled by `settle`, which returns what shall
    /// stand in place of a declaration.
    #[must_use]
    pub fn settled(&self, source: &Source, settle: impl Fn(&Conflict) -> String) -> String {
        let changed = self.changed.iter().find(|changed| changed.path == source.path);
        // Functions were only added behind the others, so places still hold.
        let mut text = changed.unwrap_or(source).text.clone();
        let mut here: Vec<_> = self.conflicts.iter().filter(|c| c.path == source.path).collect();
        here.sort_by_key(|conflict| std::cmp::Reverse(conflict.place.start));
        for conflict in here {
            text.replace_range(conflict.place.clone(), &settle(conflict));
        }
        text
    }
}

impl Conflict {
    /// Both declarations, between the marks that merge tools know.
    #[must_use]
    pub fn marked(&self, description: &str) -> String {
        format!(
            "<<<<<<< {}\n{}\n=======\n{}\n>>>>>>> {description}\n",
            self.path.display(),
            self.found,
            self.wanted
        )
    }
}
