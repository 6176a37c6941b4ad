//! A component to load, as configurations, deployment files and requests specify it.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::{Deserialize, Deserializer, Serialize, de};
use serde_json::Value;

use crate::several::one_or_several;
use crate::supervision::rules;
use crate::{
    BackendNames, QosEntry, Reaction, Remap, RestartPolicy, Restore, Resumption, SupervisionEntry,
};

/// A component to load.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct LoadRequest {
    /// Library (`.so`), description (`.gen`), or a name searched on the component path.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub library: PathBuf,
    /// Description, if it is neither in the library nor beside it.
    #[serde(default, rename = "gen", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub gen_file: Option<PathBuf>,
    /// Instance name; by default the name of the component.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Name of the daemon that runs it, in a file for several daemons; by default each of them
    /// does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub daemon: Option<String>,
    /// Middlewares of its ports and services; by default that of the daemon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub backend: Option<BackendNames>,
    /// Instance names of components to be loaded before it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub after: Vec<String>,
    /// Middlewares of single ports, by name of the port.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ports: BTreeMap<String, BackendNames>,
    /// The cell that is to run it: a process of its own, which components of one cell share. By
    /// default the daemon itself runs it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<String>,
    /// Whether it is brought up again when the process of its cell has ended.
    #[serde(default, skip_serializing_if = "RestartPolicy::is_default")]
    pub restart: RestartPolicy,
    /// Seconds between two copies of its IDS, which are put back when the process of its cell has
    /// ended by a fault; by default none are made.
    #[serde(default, deserialize_with = "seconds", skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(minimum = 0.02, maximum = 3600))]
    pub snapshot: Option<f64>,
    /// What is put back of such a copy.
    #[serde(default, skip_serializing_if = "Restore::is_default")]
    pub restore: Restore,
    /// What is done of other components when it fails: when the process of its cell ends by a fault.
    #[serde(default, deserialize_with = "one_or_several", skip_serializing_if = "Vec::is_empty")]
    pub on_failure: Vec<Reaction>,
    /// What its tasks, codels and activities are supervised by.
    #[serde(default, deserialize_with = "rules", skip_serializing_if = "Vec::is_empty")]
    pub supervision: Vec<SupervisionEntry>,
    /// Quality of service of its ports.
    #[serde(default, skip_serializing_if = "QosEntry::is_empty")]
    pub qos: QosEntry,
    /// Other names of its node, out ports and services on ROS 2, by ROS's rules: `position:=/odom`,
    /// `__ns:=/lab`, `__node:=arm`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[cfg_attr(feature = "openapi", schema(value_type = Vec<String>))]
    pub remap: Vec<Remap>,
    /// Options of its tasks that override the description, by name of the task.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub tasks: BTreeMap<String, TaskEntry>,
    /// Attributes to call as soon as the component runs: inputs by name of the attribute.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub attributes: BTreeMap<String, Value>,
    /// A copy of a library to run in place of the file, which ended the process of its cell soon
    /// after a reload.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub instead: Option<PathBuf>,
    /// The state to go on with: as `genomctl thaw` asks for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub resume: Option<Box<Resumption>>,
}

fn seconds<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    let seconds = f64::deserialize(from)?;
    if (0.02..=3600.0).contains(&seconds) {
        return Ok(Some(seconds));
    }
    Err(de::Error::custom(format!("{seconds} is not between 0.02 and 3600 s")))
}

impl LoadRequest {
    /// Keys that no user writes: daemons tell their cells by them where to go on.
    pub const INTERNAL: [&str; 2] = ["instead", "resume"];

    /// The instance name, as far as it is known before the description is read.
    #[must_use]
    pub fn instance(&self) -> String {
        match &self.name {
            Some(name) => name.clone(),
            None => self.library.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }
}

/// Options of a task that override the description.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct TaskEntry {
    /// Period, in milliseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(exclusive_minimum = 0, maximum = 1e9))]
    pub period_ms: Option<f64>,
    /// Priority, from 0, the highest, to 255.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(maximum = 255))]
    pub priority: Option<u8>,
    /// Whether to request real-time scheduling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub real_time: Option<bool>,
    /// Numbers of the processors that it may run on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cpus: Vec<usize>,
}
