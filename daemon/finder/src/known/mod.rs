//! Caches descriptions and results of checking libraries, for components that are loaded more than
//! once.
//!
//! A description is read again if one of its files changed, or would now be found in another
//! directory. A library is checked again if its contents changed, whatever its date. pkg-config
//! (`#pragma requires`) is queried again only when the description is read again.

mod seen;
mod texts;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use genom_description::diagnostic::first;
use genom_description::diagnostic::render::human;
use genom_description::model::{Component as Model, Span, Specification};
use genom_description::source::{Disk, Memory, SourceMap};
use genom_description::{Analysis, Options, preprocess, read_files};
use genom_host::{Digest, without_leftovers};
use genom_runtime::plan::{Plan, PlanError};

use seen::Seen;
pub use texts::Texts;

/// Maximum number of descriptions kept, those used last. A daemon rarely runs that many kinds of
/// components.
const MOST: usize = 64;
/// Number of libraries remembered for one description.
const BUILDS: usize = 4;

/// Where a description is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Description {
    /// In a file.
    File(PathBuf),
    /// Embedded in the library.
    Embedded {
        /// Its name in messages.
        name: PathBuf,
        /// Its text.
        text: String,
    },
    /// As it was, whatever its files hold now.
    Kept(Arc<Texts>),
}

impl Description {
    /// Its file, unless it is embedded in a library.
    pub fn file(&self) -> Option<PathBuf> {
        match self {
            Description::File(path) => Some(path.clone()),
            Description::Embedded { .. } => None,
            Description::Kept(texts) => texts.file(),
        }
    }

    /// Its name in messages.
    pub fn path(&self) -> &Path {
        match self {
            Description::File(path) | Description::Embedded { name: path, .. } => path,
            Description::Kept(texts) => texts.name(),
        }
    }
}

/// Why a description cannot be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadError {
    /// It has errors; formatted, with their places.
    #[error("{0}")]
    Description(String),
    /// It declares no component, or several.
    #[error("{}: {found}", path.display())]
    NotOne { path: PathBuf, found: String },
    /// It cannot be run.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// A description that was read, and the libraries known to match it.
pub struct Reading {
    description: Description,
    /// Directories searched for `#include <...>`.
    include: Vec<PathBuf>,
    /// The files that it was made of.
    seen: Seen,
    sources: SourceMap,
    /// Its component in compiled form.
    pub plan: Arc<Plan>,
    /// Warnings to be logged each time it is loaded.
    pub warnings: Option<String>,
    /// Digests of libraries that match it, the last one used first.
    fit: Mutex<VecDeque<Digest>>,
}

impl Reading {
    /// Reads a description from disk.
    pub fn new(description: &Description, include: &[PathBuf]) -> Result<Self, ReadError> {
        let include_dirs = include.to_vec();
        let preprocess = preprocess::Options { include_dirs, ..preprocess::Options::default() };
        let options = Options { preprocess, ..Options::default() };
        let inputs = [description.path().to_owned()];
        let (analysis, seen) = match description {
            Description::File(_) => {
                let seen = Seen::through(&Disk, None);
                (read_files(&inputs, &options, &seen), seen.finish())
            }
            Description::Embedded { name, text } => {
                let mut files = Memory::over_disk();
                files.insert(name, text.as_str());
                let seen = Seen::through(&files, Some(name));
                (read_files(&inputs, &options, &seen), seen.finish())
            }
            Description::Kept(texts) => {
                (read_files(&inputs, &options, &texts.files()), Seen::default())
            }
        };
        let warnings = drawn(&analysis)?;
        let Analysis { specification, sources, .. } = analysis;
        let index = choose(&specification, description.path())?;
        let plan = Arc::new(Plan::new(&Arc::new(specification), index)?);
        let (description, include) = (description.clone(), include.to_vec());
        Ok(Self { description, include, seen, sources, plan, warnings, fit: Mutex::default() })
    }

    /// The texts that it was read from.
    pub fn texts(&self) -> Texts {
        let texts = self.seen.contents();
        match &self.description {
            Description::Kept(texts) => Texts::clone(texts),
            Description::File(path) => Texts { name: path.clone(), embedded: false, texts },
            Description::Embedded { name, text } => {
                let own = (name.clone(), text.clone().into_bytes());
                let texts = texts.into_iter().chain([own]).collect();
                Texts { name: name.clone(), embedded: true, texts }
            }
        }
    }

    /// Its component.
    pub fn model(&self) -> &Model {
        self.plan.component()
    }

    /// The file of the description, or its name if it is embedded.
    pub fn path(&self) -> &Path {
        self.description.path()
    }

    /// Directories in which included files were searched.
    pub fn include(&self) -> &[PathBuf] {
        &self.include
    }

    /// A place in the description, as `FILE:LINE`.
    pub fn place(&self, span: Span) -> String {
        let at = self.sources.location(span);
        format!("{}:{}", at.path.display(), at.line)
    }

    /// Whether a library of this digest is known to match.
    pub fn fits(&self, library: &Digest) -> bool {
        self.fit.lock().unwrap_or_else(PoisonError::into_inner).contains(library)
    }

    /// Remembers that a library of this digest matches.
    pub fn found_to_fit(&self, library: Digest) {
        let mut fit = self.fit.lock().unwrap_or_else(PoisonError::into_inner);
        if !fit.contains(&library) {
            fit.push_front(library);
            fit.truncate(BUILDS);
        }
    }
}

/// Maximum number of diagnostics shown; the others are only counted.
const SHOWN: usize = 100;

/// Its warnings, formatted. Fails if there are errors.
fn drawn(analysis: &Analysis) -> Result<Option<String>, ReadError> {
    let drawn = || {
        let (said, rest) = first(&analysis.diagnostics, &analysis.sources, SHOWN);
        let mut text = human(&said, &analysis.sources, false);
        if !rest.is_empty() {
            text.push_str(&format!("{rest}\n"));
        }
        text
    };
    if analysis.has_errors() {
        return Err(ReadError::Description(drawn()));
    }
    Ok((analysis.diagnostics.warnings() > 0).then(drawn))
}

/// The one component of a description.
fn choose(specification: &Specification, path: &Path) -> Result<usize, ReadError> {
    let refuse = |found: String| Err(ReadError::NotOne { path: path.to_owned(), found });
    match specification.components.as_slice() {
        [_] => Ok(0),
        [] => refuse("declares no component".to_owned()),
        several => {
            // A description may also declare the components that it uses: the name of the file
            // selects one.
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            if let Some(index) = several.iter().position(|component| component.name == stem) {
                return Ok(index);
            }
            let names: Vec<_> = several.iter().map(|component| component.name.as_str()).collect();
            refuse(format!(
                "declares components {}, and the file's name is none of them",
                names.join(", ")
            ))
        }
    }
}

/// Descriptions read so far, the one used last first.
#[derive(Default)]
pub struct Known(Mutex<VecDeque<Arc<Reading>>>);

impl Known {
    /// The description, read again if it changed.
    pub fn read(
        &self,
        description: &Description,
        include: &[PathBuf],
    ) -> Result<Arc<Reading>, ReadError> {
        let is = |one: &Reading| one.description == *description && one.include == include;
        let known = self.with(|all| all.iter().find(|one| is(one)).cloned());
        let known = known.filter(|one| one.seen.is_current());
        let reading = match known {
            Some(known) => known,
            None => {
                tracing::debug!("{}: read", description.path().display());
                Arc::new(without_leftovers(|| Reading::new(description, include))?)
            }
        };
        self.with(|all| {
            all.retain(|one| !is(one));
            all.push_front(Arc::clone(&reading));
            all.truncate(MOST);
        });
        Ok(reading)
    }

    fn with<R>(&self, work: impl FnOnce(&mut VecDeque<Arc<Reading>>) -> R) -> R {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    const PLAIN: &str = "component one { ids { long n; }; };";

    #[test]
    fn a_description_is_read_once_as_long_as_its_files_are_the_same() {
        let scratch = tempfile::tempdir().unwrap();
        let at = |name: &str| scratch.path().join(name);
        fs::create_dir(at("far")).unwrap();
        fs::write(at("far/types.gen"), "struct place { double x; };").unwrap();
        let including = "#include <types.gen>\ncomponent one { ids { place p; }; };";
        fs::write(at("one.gen"), including).unwrap();
        let (known, include) = (Known::default(), [at("near"), at("far")]);
        let read = || known.read(&Description::File(at("one.gen")), &include).unwrap();
        let first = read();
        first.found_to_fit([1; 32]);
        assert!(Arc::ptr_eq(&first, &read()));
        // Written again with the same text.
        fs::write(at("one.gen"), including).unwrap();
        assert!(Arc::ptr_eq(&first, &read()));
        // Same length, and written within the resolution of file dates.
        fs::write(at("far/types.gen"), "struct place { double y; };").unwrap();
        let second = read();
        assert!(!Arc::ptr_eq(&first, &second) && !second.fits(&[1; 32]) && first.fits(&[1; 32]));
        // A file appears that is found before the other.
        fs::create_dir(at("near")).unwrap();
        fs::write(at("near/types.gen"), "struct place { long x; };").unwrap();
        let third = read();
        assert!(!Arc::ptr_eq(&second, &third));
        assert!(Arc::ptr_eq(&third, &read()));
        fs::remove_file(at("near/types.gen")).unwrap();
        assert!(!Arc::ptr_eq(&third, &read()));
        fs::remove_file(at("far/types.gen")).unwrap();
        assert!(known.read(&Description::File(at("one.gen")), &include).is_err());
    }

    #[test]
    fn the_texts_of_a_description_give_it_again_when_its_files_are_gone() {
        let scratch = tempfile::tempdir().unwrap();
        let at = |name: &str| scratch.path().join(name);
        fs::create_dir_all(at("far/deep")).unwrap();
        fs::write(at("far/types.gen"), "#include \"deep/../more.gen\"").unwrap();
        fs::write(at("far/more.gen"), "#pragma once\nstruct place { double x; };").unwrap();
        let text = "#include <types.gen>\n#include <more.gen>\n\
                    component one { ids { place p; }; };";
        fs::write(at("one.gen"), text).unwrap();
        let embedded = Description::Embedded { name: at("one.gen"), text: text.to_owned() };
        let include = [at("near"), at("far")];
        let kept_in = at("kept");
        for description in [Description::File(at("one.gen")), embedded] {
            let before = Reading::new(&description, &include).unwrap();
            before.texts().write(&kept_in).unwrap();
            fs::rename(at("far"), at("gone")).unwrap();
            assert!(Reading::new(&description, &include).is_err());
            let texts = Texts::read(&kept_in).unwrap().unwrap();
            let kept = Description::Kept(Arc::new(texts));
            let after = Reading::new(&kept, &include).unwrap();
            let digest = |one: &Reading| one.model().digest.clone();
            assert_eq!(digest(&after), digest(&before));
            assert_eq!((kept.file(), kept.path()), (description.file(), description.path()));
            assert_eq!(after.texts(), before.texts());
            let known = Known::default();
            let read = || known.read(&kept, &include).unwrap();
            assert!(Arc::ptr_eq(&read(), &read()));
            fs::rename(at("gone"), at("far")).unwrap();
        }
        assert!(Texts::read(&at("nothing")).unwrap().is_none());
    }

    #[test]
    fn descriptions_in_libraries_are_told_apart_by_their_text_and_few_are_kept() {
        let known = Known::default();
        let embedded = |name: &str, text: &str| {
            let (name, text) = (PathBuf::from(name), text.to_owned());
            known.read(&Description::Embedded { name, text }, &[]).unwrap()
        };
        let first = embedded("one.gen", PLAIN);
        assert!(Arc::ptr_eq(&first, &embedded("one.gen", PLAIN)));
        let other = embedded("one.gen", "component one { ids { double n; }; };");
        assert!(!Arc::ptr_eq(&first, &other));
        for n in 0..MOST - 1 {
            embedded(&format!("{n}.gen"), PLAIN);
        }
        assert_eq!(known.with(|all| all.len()), MOST);
        assert!(Arc::ptr_eq(&other, &embedded("one.gen", "component one { ids { double n; }; };")));
        assert!(!Arc::ptr_eq(&first, &embedded("one.gen", PLAIN)));
    }
}
