//! The texts open in the editor, each read as a specification of its own, and their diagnostics.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use genom_description::Options;
use genom_description::diagnostic::first;
use genom_description::source::{Memory, tidy};
use genom_description_tools::navigate::Navigator;
use lsp_types::{Diagnostic, PublishDiagnosticsParams, Uri};

use crate::{convert, place};

/// Maximum number of diagnostics published for one text.
const TOLD: usize = 1000;

/// An open text.
struct Document {
    version: i32,
    text: String,
    /// `None` if the text, or a file it includes, changed since it was read.
    read: Option<Navigator>,
}

/// All open texts, by path.
pub(super) struct Workspace {
    options: Options,
    documents: BTreeMap<PathBuf, Document>,
    /// Diagnostics published last: by the text they were found from, then by the file they are in.
    told: BTreeMap<PathBuf, BTreeMap<PathBuf, Vec<Diagnostic>>>,
    /// Files whose diagnostics changed and have to be published.
    untold: BTreeSet<PathBuf>,
}

impl Workspace {
    pub(super) fn new(options: Options) -> Self {
        let (told, untold) = (BTreeMap::new(), BTreeSet::new());
        Self { options, documents: BTreeMap::new(), told, untold }
    }

    /// Opens or changes a text.
    pub(super) fn set(&mut self, uri: &Uri, version: i32, text: String) {
        let Some(path) = place::path_of(uri) else { return };
        self.touch(&path);
        self.documents.insert(path, Document { version, text, read: None });
    }

    /// Closes a text: from now on the file on disk counts, and its own diagnostics are withdrawn.
    pub(super) fn close(&mut self, uri: &Uri) {
        let Some(path) = place::path_of(uri) else { return };
        self.touch(&path);
        self.documents.remove(&path);
        if let Some(told) = self.told.remove(&path) {
            self.untold.extend(told.into_keys());
        }
    }

    /// Files on disk changed.
    pub(super) fn forget(&mut self) {
        for document in self.documents.values_mut() {
            document.read = None;
        }
    }

    /// Marks texts for reading again: those that include the file, and those with a missing
    /// include, which it may be.
    fn touch(&mut self, path: &Path) {
        for document in self.documents.values_mut() {
            let concerned = document.read.as_ref().is_some_and(|read| {
                let mut files = read.analysis.sources.files();
                let missing = read.analysis.diagnostics.iter().any(|said| said.code == "E0121");
                missing || files.any(|(_, file)| tidy(file.path()) == path)
            });
            if concerned {
                document.read = None;
            }
        }
    }

    /// Reads changed texts, and returns the diagnostics to publish.
    pub(super) fn refresh(&mut self) -> Vec<PublishDiagnosticsParams> {
        let stale: Vec<PathBuf> = self
            .documents
            .iter()
            .filter(|(_, document)| document.read.is_none())
            .map(|(path, _)| path.clone())
            .collect();
        if !stale.is_empty() {
            let mut files = Memory::over_disk();
            for (path, document) in &self.documents {
                files.insert(path, document.text.as_str());
            }
            for path in stale {
                let read = Navigator::read(std::slice::from_ref(&path), &self.options, &files);
                let found = diagnostics(&path, &read);
                self.untold.extend(found.keys().cloned());
                if let Some(before) = self.told.insert(path.clone(), found) {
                    self.untold.extend(before.into_keys());
                }
                if let Some(document) = self.documents.get_mut(&path) {
                    document.read = Some(read);
                }
            }
        }
        let untold = std::mem::take(&mut self.untold);
        untold.into_iter().filter_map(|path| self.about(&path)).collect()
    }

    /// All diagnostics in a file, from whichever texts they were found.
    fn about(&self, path: &Path) -> Option<PublishDiagnosticsParams> {
        let mut diagnostics: Vec<Diagnostic> = Vec::new();
        for one in self.told.values().filter_map(|told| told.get(path)).flatten() {
            if !diagnostics.contains(one) {
                diagnostics.push(one.clone());
            }
        }
        let version = self.documents.get(path).map(|document| document.version);
        Some(PublishDiagnosticsParams { uri: place::uri_of(path)?, diagnostics, version })
    }

    /// An open text as it was read, and the index of its file there.
    pub(super) fn find(&self, uri: &Uri) -> Option<(&Navigator, u32)> {
        let path = place::path_of(uri)?;
        let read = self.documents.get(&path)?.read.as_ref()?;
        Some((read, read.file(&path)?))
    }
}

/// Diagnostics by file. The text itself is always included, so that earlier diagnostics are
/// withdrawn.
fn diagnostics(root: &Path, read: &Navigator) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
    let mut found = BTreeMap::from([(root.to_owned(), Vec::new())]);
    let sources = &read.analysis.sources;
    let (first, _) = first(&read.analysis.diagnostics, sources, TOLD);
    for said in &first {
        let file = sources.file(said.span.file).filter(|file| !file.is_synthetic());
        let path = file.map_or_else(|| root.to_owned(), |file| tidy(file.path()));
        found.entry(path).or_default().push(convert::diagnostic(said, sources));
    }
    if !read.analysis.has_errors() {
        let specification = Arc::new(read.analysis.specification.clone());
        for hint in genom_formal::hints(&specification).into_iter().take(TOLD) {
            let file = hint.span.and_then(|span| sources.file(span.file));
            let file = file.filter(|file| !file.is_synthetic());
            let path = file.map_or_else(|| root.to_owned(), |file| tidy(file.path()));
            found.entry(path).or_default().push(convert::hint(&hint, sources));
        }
    }
    found
}
