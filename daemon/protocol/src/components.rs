//! Components that run.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::{BackendNames, RunningCodel, Spin};

/// Components, in the order they were loaded.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Components {
    /// Those that run.
    pub components: Vec<Component>,
    /// Names of those that are being loaded, or are to be at the daemon's start; absent without any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loading: Vec<String>,
    /// What is left of components that did not stop in time; absent when nothing is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_behind: Vec<LeftBehind>,
}

/// What is left of a component: threads in codels that do not return. Its name is free.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LeftBehind {
    /// The name it had.
    pub was: String,
    /// Name in the description.
    pub component: String,
    /// `left behind: stuck in CODEL for 12 s`.
    pub state: String,
}

/// A component that runs.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Component {
    /// Instance name.
    pub name: String,
    /// Name in the description.
    pub component: String,
    /// `running`, `damaged` (its codels wrote past the memory they were given),
    /// `stuck in CODEL for 12 s`, or `spins in CODEL for 12 s`.
    pub state: String,
    /// Codels that have not returned for so long that they count as stuck; absent without any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stuck: Vec<RunningCodel>,
    /// Tasks that keep a processor and do not pause; absent without any.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spins: Vec<Spin>,
    /// Middlewares of its services, and of ports that have no others.
    pub backend: BackendNames,
    /// Middlewares of ports that have others.
    #[serde(default)]
    pub port_backends: BTreeMap<String, BackendNames>,
    /// File of the library.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub library: PathBuf,
    /// How many activities run.
    pub activities: usize,
    /// Services of others that its codels call, by name: what can be connected to one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remotes: Vec<String>,
}

/// A component is gone.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Unloaded {
    /// It is.
    pub unloaded: bool,
}
