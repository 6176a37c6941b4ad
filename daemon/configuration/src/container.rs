//! The container into which ROS 2 loads components.

use genom_protocol::BackendNames;
use serde::{Deserialize, Serialize};

use crate::error::UsageError;

/// Section `[container]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ContainerSection {
    /// Libraries, descriptions or names of the components that ROS may load. Without one there is no
    /// container.
    pub components: Vec<String>,
    /// Name of its node.
    pub node: String,
    /// Middlewares of the ports and services of what it loads.
    pub backend: BackendNames,
    /// Components that it holds at a time.
    pub most: usize,
}

impl Default for ContainerSection {
    fn default() -> Self {
        Self {
            components: Vec::new(),
            node: "container".to_owned(),
            backend: BackendNames::one("ros2"),
            most: 100,
        }
    }
}

impl ContainerSection {
    /// Checks the name of the node.
    ///
    /// # Errors
    /// It is none.
    pub fn check(&self) -> Result<(), UsageError> {
        let first = self.node.starts_with(|c: char| c.is_ascii_alphabetic());
        match first && self.node.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            true => Ok(()),
            false => Err(UsageError::Container(self.node.clone())),
        }
    }
}
