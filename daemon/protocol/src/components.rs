//! Running components.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use crate::{BackendNames, Rule, RunningCodel, Spin};

/// The components, in the order they were loaded.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Components {
    /// The running components.
    pub components: Vec<Component>,
    /// Names of those being loaded now, or still to be loaded at the daemon's start; absent if
    /// none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub loading: Vec<String>,
    /// Components that did not stop in time; absent if none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_behind: Vec<LeftBehind>,
}

/// What is left of a component that did not stop: threads in codels that do not return. Its name is
/// free again.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LeftBehind {
    /// Its instance name.
    pub was: String,
    /// Its name in the description.
    pub component: String,
    /// `left behind: stuck in CODEL for 12 s`.
    pub state: String,
}

/// A running component.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Component {
    /// Instance name.
    pub name: String,
    /// Its name in the description.
    pub component: String,
    /// `running`, `held` (its tasks wait until the system of `genomctl thaw` is complete), `down` (the process of its cell has ended), `damaged` (its codels wrote past the
    /// memory they were given), `stuck in CODEL for 12 s`, or `spins in CODEL for 12 s`.
    pub state: String,
    /// Codels that count as stuck; absent if none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stuck: Vec<RunningCodel>,
    /// Tasks that occupy a processor and never pause; absent if none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spins: Vec<Spin>,
    /// Middlewares of its services, and of its ports unless listed in `port_backends`.
    pub backend: BackendNames,
    /// Middlewares of ports that use others.
    #[serde(default)]
    pub port_backends: BTreeMap<String, BackendNames>,
    /// The cell that runs it; absent when the daemon itself does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<String>,
    /// Path of the library.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub library: PathBuf,
    /// Number of running activities.
    pub activities: usize,
    /// What it is supervised by; absent if nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub supervision: Vec<Rule>,
    /// What was not taken over as it was when its state was put back; absent if all was, or none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Names of its remotes: services of other components that its codels call.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remotes: Vec<String>,
}

/// A component was unloaded.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Unloaded {
    /// Always true.
    pub unloaded: bool,
}
