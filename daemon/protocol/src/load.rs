//! A component to load, as configurations, deployment files and requests say it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::{BackendNames, QosEntry};

/// A component to load.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LoadRequest {
    /// Library (`.so`), description (`.gen`), or a name on the component path.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub library: PathBuf,
    /// Description, when it is neither in the library nor beside it.
    #[serde(default, rename = "gen", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub gen_file: Option<PathBuf>,
    /// Instance name; by default the component's name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Daemon that is to run it, when a file describes several; by default each does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub daemon: Option<String>,
    /// Middlewares of its ports and services; by default that of the daemon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub backend: Option<BackendNames>,
    /// Instance names of components that are to run before it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub after: Vec<String>,
    /// Middlewares of single ports.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ports: BTreeMap<String, BackendNames>,
    /// Quality of service of its ports.
    #[serde(default, skip_serializing_if = "QosEntry::is_empty")]
    pub qos: QosEntry,
    /// Changes to what the description says of tasks.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tasks: BTreeMap<String, TaskEntry>,
    /// Inputs of attributes that are called as soon as it runs.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub attributes: BTreeMap<String, Value>,
}

impl LoadRequest {
    /// The instance name, as far as it can be told before the description is read.
    #[must_use]
    pub fn instance(&self) -> String {
        match &self.name {
            Some(name) => name.clone(),
            None => self.library.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }
}

/// What may be changed of a task.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TaskEntry {
    /// Another period, in milliseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0, maximum = 1e9))]
    pub period_ms: Option<f64>,
    /// 0, the highest, to 255.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(maximum = 255))]
    pub priority: Option<u8>,
    /// Whether to ask for real-time scheduling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub real_time: Option<bool>,
    /// Processors to run on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cpus: Vec<usize>,
}
