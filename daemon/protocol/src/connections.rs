//! Connections: which out port an in port reads, and which service a remote calls.

use serde::{Deserialize, Serialize};
use strum::Display;

use crate::is_false;

/// A connection to make.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ConnectionRequest {
    /// The in port, `COMPONENT/PORT` or `COMPONENT/PORT/ELEMENT`, or the remote.
    #[serde(rename = "in")]
    pub inport: String,
    /// The out port to read, or the service to call.
    #[serde(rename = "out")]
    pub outport: String,
    /// Which unread samples are kept for the reader: `latest`, `queue:N` or `ring:N`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(
        feature = "openapi",
        schema(
            pattern = "^(latest|(queue|ring):([1-9][0-9]{0,3}|[1-5][0-9]{4}|6[0-4][0-9]{3}|65[0-4][0-9]{2}|655[0-2][0-9]|6553[0-6]))$"
        )
    )]
    pub policy: Option<String>,
    /// Middleware to use; by default that of the out port. An out port of this daemon that is not on
    /// it is opened there, and closed again with the last connection over it.
    #[serde(default, alias = "backend", skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
    /// Connect even if the out port does not exist yet.
    #[serde(default, skip_serializing_if = "is_false")]
    pub wait: bool,
}

/// The connections of all components.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Connections {
    /// The connections, by component.
    pub connections: Vec<Connection>,
}

/// A connection.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Connection {
    /// Whether it connects ports, or a remote and a service.
    pub kind: ConnectionKind,
    /// Address of the in port or the remote.
    #[serde(rename = "in")]
    pub inport: String,
    /// Address of the out port or the service.
    #[serde(rename = "out")]
    pub outport: String,
    /// Its middleware; absent for a remote whose service is in the same daemon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub backend: Option<String>,
    /// Whether that middleware was asked for (`over`): the connection stays on it.
    #[serde(default, skip_serializing_if = "is_false")]
    pub fixed: bool,
    /// Its policy; absent for a remote.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy: Option<String>,
}

/// Kind of a connection.
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

/// An in port or a remote was disconnected.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Disconnected {
    /// Its address.
    pub disconnected: String,
}
