//! Components that ROS 2 loads and starts.

use genom_nearest::suggest;
use genom_protocol::Deployment;
use serde::{Deserialize, Serialize};

use crate::error::UsageError;

/// Section `[lifecycle]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LifecycleSection {
    /// Instance names of components that are managed nodes of ROS 2.
    pub components: Vec<String>,
}

impl LifecycleSection {
    /// Checks the section against the components that there are.
    ///
    /// # Errors
    /// One of its names is that of no component.
    pub fn check(&self, deployment: &Deployment) -> Result<(), UsageError> {
        let names: Vec<String> =
            deployment.component.iter().map(|component| component.instance()).collect();
        match self.components.iter().find(|name| !names.contains(name)) {
            Some(name) => Err(UsageError::Lifecycle {
                name: name.clone(),
                help: suggest(name, names.iter().map(String::as_str)),
            }),
            None => Ok(()),
        }
    }
}
