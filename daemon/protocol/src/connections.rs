//! Connections: what feeds which in port, and which services remotes call.

use serde::{Deserialize, Serialize};
use strum::Display;

use crate::is_false;

/// A connection to make.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ConnectionRequest {
    /// The in port, `COMPONENT/PORT` or `COMPONENT/PORT/ELEMENT`; or a remote.
    #[serde(rename = "in")]
    pub inport: String,
    /// The out port that feeds it; or the service that a remote calls.
    #[serde(rename = "out")]
    pub outport: String,
    /// What the reader gets of the samples it has not read: `latest`, `queue:N` or `ring:N`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "openapi",
        schema(
            pattern = "^(latest|(queue|ring):([1-9][0-9]{0,3}|[1-5][0-9]{4}|6[0-4][0-9]{3}|65[0-4][0-9]{2}|655[0-2][0-9]|6553[0-6]))$"
        )
    )]
    pub policy: Option<String>,
    /// Middleware to use; by default that of the out port.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub backend: Option<String>,
    /// Connect also when the out port does not exist yet.
    #[serde(default, skip_serializing_if = "is_false")]
    pub wait: bool,
}

/// Connections of all components.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Connections {
    /// By component.
    pub connections: Vec<Connection>,
}

/// A connection.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Connection {
    /// Of a port, or of a remote.
    pub kind: ConnectionKind,
    /// The in port, or the remote.
    #[serde(rename = "in")]
    pub inport: String,
    /// The out port, or the service.
    #[serde(rename = "out")]
    pub outport: String,
    /// Its middleware; none for a remote within the daemon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub backend: Option<String>,
    /// Its policy; none for a remote.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy: Option<String>,
}

/// What a connection is of.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum ConnectionKind {
    /// An in port reads an out port.
    Port,
    /// A remote calls a service.
    Service,
}

/// An in port or a remote is connected no more.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Disconnected {
    /// Its address.
    pub disconnected: String,
}
