//! Middlewares: what they support, and what is visible on them.

use std::collections::BTreeMap;
use std::net::IpAddr;

use serde::{Deserialize, Serialize};
use strum::Display;

use crate::is_false;

/// `?visible=true&trouble=true`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct MiddlewareParameters {
    /// Include what is visible on open middlewares.
    #[serde(default, skip_serializing_if = "is_false")]
    pub visible: bool,
    /// Include what keeps open middlewares from others, which may take some seconds.
    #[serde(default, skip_serializing_if = "is_false")]
    pub trouble: bool,
}

/// The middlewares of the daemon.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Middlewares {
    /// Name of the default middleware, used by components that name none.
    pub default: String,
    /// All middlewares that the daemon was built with.
    pub middlewares: Vec<Middleware>,
}

/// A middleware.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Middleware {
    /// Its name, as given to `--backend`.
    pub name: String,
    /// Version of the library that implements it.
    pub version: String,
    /// What it supports; only if it is open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capabilities: Option<Capabilities>,
    /// Where peers meet on it, such as its domain or addresses: values by name of the option.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub meet: BTreeMap<String, String>,
    /// Endpoints visible on it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub endpoints: Option<Vec<Endpoint>>,
    /// Peers that do not announce what they opened.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub strangers: Vec<Stranger>,
    /// Harmful messages of peers that were dropped, by reason.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub refused: Vec<Refused>,
    /// What keeps it from others.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub trouble: Vec<Trouble>,
    /// Why it was not opened when it was needed last; nothing once it is open.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub closed: Option<String>,
    /// Why the visible endpoints cannot be listed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// What keeps a middleware from others.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Trouble {
    /// The cause, as a sentence without a full stop.
    pub what: String,
    /// What to do about it.
    pub fix: String,
}

/// What a middleware supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Capabilities {
    /// Types with unbounded strings or sequences.
    pub variable_size: bool,
    /// Reading without a copy by the middleware: readers see the writer's memory.
    pub zero_copy: bool,
    /// Peers in other processes of the machine.
    pub cross_process: bool,
    /// Peers on other machines.
    pub cross_host: bool,
    /// Services.
    pub services: bool,
    /// Services that programs other than genomd can call.
    pub native_services: bool,
}

/// An endpoint visible on a middleware.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Endpoint {
    /// Its kind.
    pub kind: EndpointKind,
    /// Its name as the middleware spells it: `demo/position` for those of genomd.
    pub address: String,
    /// Name of its type, as far as known.
    pub ty: String,
}

/// Kind of an endpoint.
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

/// A peer that does not announce what it opened, as programs other than genomd may do.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Stranger {
    /// A reader of an out port of this daemon; the type it expects is unknown.
    Reader {
        /// Address of the port.
        address: String,
    },
    /// A connected session; what it opened cannot be seen.
    Session {
        /// Its name on the middleware.
        name: String,
        /// Its role, in the terms of the middleware.
        role: String,
    },
}

/// Messages of peers that were dropped for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Refused {
    /// The reason, worded as in the log: `far ahead of what its writer sent`.
    pub why: String,
    /// How many were dropped so far.
    pub count: u64,
    /// Sender of the last one, as far as known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "openapi", schema(value_type = Option<String>))]
    pub peer: Option<IpAddr>,
}
