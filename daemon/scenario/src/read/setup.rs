//! What runs when a scenario begins: the keys that a file and each scenario have.

use std::path::{Path, PathBuf};

use genom_protocol::{ConnectionEntry, LoadRequest};
use toml::de::DeValue;

use super::fields::{Fields, Spot, typed};
use super::found::Found;
use super::value::Shown;
use crate::model::Setup;

/// Reads the keys of a file or a scenario in a directory.
pub(super) fn read(fields: &Fields<'_, '_, '_>, directory: &Path) -> Setup {
    let found = fields.found;
    Setup {
        deployment: fields.text("deployment").map(|file| absolute(directory, Path::new(file))),
        components: fields
            .list("components")
            .filter_map(|one| component(one, "a component", directory, found))
            .collect(),
        connections: fields
            .list("connections")
            .filter_map(|one| typed::<ConnectionEntry>(one, "a connection", found))
            .collect(),
        backend: fields.text("backend").map(str::to_owned),
        path: fields.texts("path").into_iter().map(|it| absolute(directory, it.as_ref())).collect(),
    }
}

impl Setup {
    /// What a scenario says, and what its file says besides.
    pub(super) fn over(mut self, file: &Self) -> Self {
        self.deployment = self.deployment.or_else(|| file.deployment.clone());
        self.backend = self.backend.or_else(|| file.backend.clone());
        self.components.splice(0..0, file.components.iter().cloned());
        self.connections.splice(0..0, file.connections.iter().cloned());
        self.path.extend(file.path.iter().cloned());
        self
    }
}

/// A component to load: its library, or a table as in a deployment file.
pub(super) fn component(
    value: Spot<'_, '_>,
    what: &str,
    directory: &Path,
    found: &Found,
) -> Option<LoadRequest> {
    let mut request = match value.get_ref() {
        DeValue::String(library) => {
            LoadRequest { library: PathBuf::from(library.as_ref()), ..LoadRequest::default() }
        }
        DeValue::Table(_) => typed::<LoadRequest>(value, what, found)?,
        other => {
            let message = format!("{what} is a library, or a table, not {}", Shown(other));
            found.add(value.span(), message, Some("library = \"demo\"".to_owned()));
            return None;
        }
    };
    // A word alone is searched for, as in a deployment file.
    if request.library.components().count() > 1 {
        request.library = absolute(directory, &request.library);
    }
    request.gen_file = request.gen_file.map(|file| absolute(directory, &file));
    Some(request)
}

/// A path that is relative to the directory of the file.
pub(super) fn absolute(directory: &Path, path: &Path) -> PathBuf {
    let path = directory.join(path);
    std::path::absolute(&path).unwrap_or(path)
}
