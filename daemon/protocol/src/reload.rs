//! The exchange of a running component's library.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The library that a running component is to run from now on.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ReloadRequest {
    /// Library (`.so`), description (`.gen`), or a name searched on the component path; by default
    /// what it was loaded from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub library: Option<PathBuf>,
    /// Description, if it is neither in the library nor beside it.
    #[serde(default, rename = "gen", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub gen_file: Option<PathBuf>,
    /// With another description: the component is stopped before the new one starts, which its start
    /// codels may need. Periods are missed meanwhile.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stop_first: bool,
}

/// A component runs another library.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ComponentReload {
    /// Instance name.
    pub component: String,
    /// Path of the library that it runs now.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub library: PathBuf,
    /// Whether another one took its place, with its IDS, last values of ports and activities: its
    /// description changed, or it has native data. Start codels of that ran, and stop codels of the one
    /// before.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub restarted: bool,
    /// What is new, gone or converted, and what does not go on, with the reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Whether the library before it stays in memory, because something may still use it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub old_stays: bool,
}
