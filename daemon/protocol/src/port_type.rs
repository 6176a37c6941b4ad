//! The memory layout of a port's type, for programs that share memory with the daemon.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// The type of a port, with all types that it consists of.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PortType {
    /// Name of the type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Digest of the type; ports of equal digest can be connected.
    pub digest: String,
    /// The type as ROS 2 and recordings know it.
    pub message: MessageType,
    /// The type itself, then the types that it consists of: `kind`, `name`, `size` and `align` in
    /// bytes, `fixed`, and further members that depend on the kind. They refer to each other by
    /// index in this list.
    #[cfg_attr(feature = "openapi", schema(value_type = Vec<Object>))]
    pub types: Vec<Map<String, Value>>,
}

/// A type as a ROS 2 message.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct MessageType {
    /// `PACKAGE/msg/NAME`.
    pub name: String,
    /// Its definition, followed by those of the messages it contains; absent if the type contains a
    /// native.
    pub definition: Option<String>,
}
