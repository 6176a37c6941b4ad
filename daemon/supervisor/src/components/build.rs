//! What a component runs.

use std::path::PathBuf;
use std::sync::Arc;

use genom_configuration::LoadRequest;
use genom_host::Digest;

use genom_finder::{Description, Reading};

/// What a component runs.
#[derive(Clone)]
pub struct Build {
    /// The request by which it was loaded; names the library that was loaded last.
    pub request: LoadRequest,
    /// Path of the library.
    pub library: PathBuf,
    /// Identifies the content of that file.
    pub digest: Digest,
    /// Where the description is.
    pub description: Description,
    /// The description as it was read.
    pub reading: Arc<Reading>,
}
