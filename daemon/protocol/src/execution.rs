//! Which threads execute components.

use serde::{Deserialize, Serialize};
use strum::Display;

/// Which threads execute the tasks and requests of components.
#[derive(Clone, Copy, Debug, Default, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum ExecutionKind {
    /// A thread for each task, and threads for the requests of each component.
    #[default]
    Threads,
    /// One thread for all components of a process, in the order of deadlines.
    Single,
}
