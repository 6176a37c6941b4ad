//! The type of a port as it lies in memory, for programs that share memory with the daemon.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The type of a port, and all types it is made of.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PortType {
    /// Its name.
    #[serde(rename = "type")]
    pub ty: String,
    /// Ports of one digest can be connected.
    pub digest: String,
    /// As ROS 2 and recordings know it.
    pub message: MessageType,
    /// The types it is made of, itself first: `kind`, `name`, `size` and `align` in bytes, `fixed`,
    /// and what the kind asks for. They name each other by their place in this list.
    #[cfg_attr(feature = "openapi", schema(value_type = Vec<Object>))]
    pub types: Vec<Map<String, Value>>,
}

/// A type as a ROS 2 message.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct MessageType {
    /// `PACKAGE/msg/NAME`.
    pub name: String,
    /// Its definition, with those of the messages in it; none of a type with natives inside.
    pub definition: Option<String>,
}
