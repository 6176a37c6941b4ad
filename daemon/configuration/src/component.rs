//! A component to load, as configurations, deployment files and requests say it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use genom_runtime::TaskOptions;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::ToSchema;

use crate::backends::BackendNames;
use crate::qos::QosEntry;

/// A component to load.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadRequest {
    /// Library (`.so`), description (`.gen`), or a name on the component path.
    #[schema(value_type = String)]
    pub library: PathBuf,
    /// Description, when it is neither in the library nor beside it.
    #[serde(default, rename = "gen", skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<String>)]
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
    pub fn instance(&self) -> String {
        match &self.name {
            Some(name) => name.clone(),
            None => self.library.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
        }
    }
}

/// What may be changed of a task.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TaskEntry {
    /// Another period, in milliseconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(exclusive_minimum = 0, maximum = 1e9)]
    pub period_ms: Option<f64>,
    /// 0, the highest, to 255.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(maximum = 255)]
    pub priority: Option<u8>,
    /// Whether to ask for real-time scheduling.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub real_time: Option<bool>,
    /// Processors to run on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub cpus: Vec<usize>,
}

impl TaskEntry {
    /// For the runtime; a period that is none is refused with a sentence.
    pub fn options(&self) -> Result<TaskOptions, String> {
        let period = match self.period_ms {
            None => None,
            Some(ms) => {
                let period = Duration::try_from_secs_f64(ms / 1e3).ok();
                let period = period.filter(|period| !period.is_zero());
                Some(period.ok_or_else(|| format!("period_ms = {ms} is no period"))?)
            }
        };
        Ok(TaskOptions {
            period,
            priority: self.priority.map(u32::from),
            real_time: self.real_time,
            cpus: self.cpus.clone(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_period_must_be_one() {
        let entry = |ms| TaskEntry { period_ms: Some(ms), ..TaskEntry::default() };
        assert_eq!(entry(2.5).options().unwrap().period, Some(Duration::from_micros(2500)));
        for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(entry(wrong).options().is_err(), "{wrong}");
        }
    }
}
