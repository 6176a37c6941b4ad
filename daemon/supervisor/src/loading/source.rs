//! What a component is loaded from.

use std::sync::Arc;

use genom_configuration::LoadRequest;
use genom_host::{Component, Contents, Digest};

use super::error::LoadError;
use super::locate::{Located, locate};
use super::warnings::tell_warnings;
use crate::components::Build;
use crate::known::Reading;
use crate::supervisor::Supervisor;

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
        let kept = LoadRequest { library: instead.clone(), ..request.clone() };
        let mut located = locate(&kept, &supervisor.settings.path)?;
        let contents = match located.contents.take() {
            Some(contents) => contents,
            None => Contents::read(instead)?,
        };
        located.library.clone_from(&request.library);
        located.contents = Some(Contents { path: request.library.clone(), ..contents });
        Self::of(supervisor, located)
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
