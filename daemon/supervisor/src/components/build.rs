//! What a component runs.

use std::path::PathBuf;

use genom_configuration::LoadRequest;
use genom_host::Digest;

/// What a component runs.
#[derive(Clone, Debug)]
pub struct Build {
    /// The request by which it was loaded; names the library that was loaded last.
    pub request: LoadRequest,
    /// Path of the library.
    pub library: PathBuf,
    /// Identifies the content of that file.
    pub digest: Digest,
    /// File of the description, unless that is in the library.
    pub description: Option<PathBuf>,
}
