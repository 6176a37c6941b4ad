//! Middlewares: what they can do, and what is visible on them.

use std::collections::BTreeMap;
use std::net::IpAddr;

use serde::{Deserialize, Serialize};
use strum::Display;

use crate::is_false;

/// `?visible=true`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct MiddlewareParameters {
    /// Also list what is visible on the open ones.
    #[serde(default, skip_serializing_if = "is_false")]
    pub visible: bool,
}

/// The middlewares of the daemon.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Middlewares {
    /// The one of components that name none.
    pub default: String,
    /// All that the daemon knows.
    pub middlewares: Vec<Middleware>,
}

/// A middleware.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Middleware {
    /// What `--backend` calls it.
    pub name: String,
    /// Version of the library behind it.
    pub version: String,
    /// What it can do; of an open one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capabilities: Option<Capabilities>,
    /// Where others meet it, by the names of its own options.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub meet: BTreeMap<String, String>,
    /// What is visible on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub endpoints: Option<Vec<Endpoint>>,
    /// Who is there besides and does not tell what it opens.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strangers: Vec<Stranger>,
    /// What peers sent that would have harmed and was refused.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<Refused>,
    /// Why nothing is visible.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// What a middleware can do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Capabilities {
    /// Carries types that hold unbounded strings or sequences.
    pub variable_size: bool,
    /// Readers see the writer's memory without a copy by the middleware.
    pub zero_copy: bool,
    /// Reaches other processes of the machine.
    pub cross_process: bool,
    /// Reaches other machines.
    pub cross_host: bool,
    /// Serves and calls services.
    pub services: bool,
    /// Shows services to peers that are no genomd.
    pub native_services: bool,
}

/// Something visible on a middleware.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Endpoint {
    /// What it is.
    pub kind: EndpointKind,
    /// Its name, in the middleware's own spelling: `demo/position` for ours.
    pub address: String,
    /// Name of its type, as far as known.
    pub ty: String,
}

/// What an endpoint is.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum EndpointKind {
    /// An out port.
    Publisher,
    /// An in port.
    Subscription,
    /// A service.
    Service,
}

/// Somebody on a middleware who does not tell what it opens, as programs of other makes may.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Stranger {
    /// Somebody reads an out port of this side; as which type is not known.
    Reader {
        /// The port.
        address: String,
    },
    /// Somebody is connected; what it opened cannot be seen.
    Session {
        /// Its name on the middleware.
        name: String,
        /// What it is there, in the middleware's own words.
        role: String,
    },
}

/// Messages of peers that were not let in, for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Refused {
    /// The reason, in the words of the log: `far ahead of what its writer sent`.
    pub why: String,
    /// How many there were so far.
    pub count: u64,
    /// Who sent the last one, as far as known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub peer: Option<IpAddr>,
}
