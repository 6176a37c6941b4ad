//! What a component is loaded from.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use genom_configuration::LoadRequest;
use genom_host::{Component, Contents, Digest};

use super::error::LoadError;
use super::warnings::tell_warnings;
use crate::components::Build;
use crate::supervisor::Supervisor;
use genom_finder::{Description, Reading, Texts};
use genom_finder::{Located, locate};

/// Library and description, found and read.
pub(crate) struct Source {
    pub(crate) located: Located,
    pub(crate) reading: Arc<Reading>,
    /// The library, once it was opened and compared with the description.
    pub(crate) opened: Option<(Component, Digest)>,
}

impl Source {
    /// Finds what a request names.
    pub(crate) fn find(supervisor: &Supervisor, request: &LoadRequest) -> Result<Self, LoadError> {
        let Some(instead) = &request.instead else {
            return Self::of(supervisor, locate(request, &supervisor.settings.path)?);
        };
        let file = texts_beside(instead);
        let read = Texts::read(&file);
        let read = read.map_err(|source| LoadError::Kept { file: file.clone(), source })?;
        let contents = Contents::read(instead)?;
        let library = request.library.clone();
        let description = match read {
            Some(texts) => Description::Kept(Arc::new(texts)),
            // Its files have not changed, or it is in the library.
            None => {
                let kept = LoadRequest { library: instead.clone(), ..request.clone() };
                locate(&kept, &supervisor.settings.path)?.description
            }
        };
        let contents = Some(Contents { path: library.clone(), ..contents });
        Self::of(supervisor, Located { library, description, contents })
    }

    /// Reads the description of what was found.
    pub(crate) fn of(supervisor: &Supervisor, located: Located) -> Result<Self, LoadError> {
        let reading = supervisor.known.read(&located.description, &supervisor.settings.include)?;
        tell_warnings(&located, &reading);
        Ok(Self { located, reading, opened: None })
    }

    /// What a component runs, as it was when that was loaded.
    pub(crate) fn as_it_was(build: Build, contents: Option<Contents>) -> Self {
        let Build { library, description, reading, .. } = build;
        Self { located: Located { library, description, contents }, reading, opened: None }
    }
}

/// Where the texts of the description are that belongs to a copy of a library.
pub(crate) fn texts_beside(copy: &Path) -> PathBuf {
    copy.with_extension("texts")
}
