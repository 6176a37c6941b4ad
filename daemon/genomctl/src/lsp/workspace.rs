//! The texts open in the editor, read as specifications of their own, and what is wrong there.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use genom_description::Options;
use genom_description::diagnostic::first;
use genom_description::source::{Memory, tidy};
use genom_description_tools::navigate::Navigator;
use lsp_types::{Diagnostic, PublishDiagnosticsParams, Uri};

use super::{convert, place};

/// Mistakes of one text that are told: an editor shows a few at once.
const TOLD: usize = 1000;

/// An open text.
struct Document {
    version: i32,
    text: String,
    /// `None` when it, or what it includes, changed since it was read.
    read: Option<Navigator>,
}

/// Everything open, by path.
pub(super) struct Workspace {
    options: Options,
    documents: BTreeMap<PathBuf, Document>,
    /// What was told last, by the text it was found from, then by the file it is about.
    told: BTreeMap<PathBuf, BTreeMap<PathBuf, Vec<Diagnostic>>>,
    /// Files about which something else is to be told.
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

    /// Closes a text: the disk counts again, and nothing more is said about it.
    pub(super) fn close(&mut self, uri: &Uri) {
        let Some(path) = place::path_of(uri) else { return };
        self.touch(&path);
        self.documents.remove(&path);
        if let Some(told) = self.told.remove(&path) {
            self.untold.extend(told.into_keys());
        }
    }

    /// The disk changed.
    pub(super) fn forget(&mut self) {
        for document in self.documents.values_mut() {
            document.read = None;
        }
    }

    /// Forgets what was read of the texts that include a file; of those that found nothing too,
    /// for it may be what they look for.
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

    /// Reads what changed; what to tell about which file.
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

    /// All that is said about a file, from whatever text it was found.
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

    /// An open text as it was read, and its rank in there.
    pub(super) fn find(&self, uri: &Uri) -> Option<(&Navigator, u32)> {
        let path = place::path_of(uri)?;
        let read = self.documents.get(&path)?.read.as_ref()?;
        Some((read, read.file(&path)?))
    }
}

/// What is wrong, by file; the text itself is always among them, so that what was wrong goes.
fn diagnostics(root: &Path, read: &Navigator) -> BTreeMap<PathBuf, Vec<Diagnostic>> {
    let mut found = BTreeMap::from([(root.to_owned(), Vec::new())]);
    let sources = &read.analysis.sources;
    let (first, _) = first(&read.analysis.diagnostics, sources, TOLD);
    for said in &first {
        let file = sources.file(said.span.file).filter(|file| !file.is_synthetic());
        let path = file.map_or_else(|| root.to_owned(), |file| tidy(file.path()));
        found.entry(path).or_default().push(convert::diagnostic(said, sources));
    }
    found
}
