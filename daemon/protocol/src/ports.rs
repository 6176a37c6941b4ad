//! Ports: what they are connected to, their values, and what passes through them.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use strum::Display;

use crate::BackendNames;

/// `?element=ID`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct ValueParameters {
    /// Element of a multiple port.
    pub element: Option<String>,
}

/// `?values=BOOLEAN`
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(
    feature = "openapi",
    derive(utoipa::IntoParams),
    into_params(parameter_in = Query)
)]
pub struct PortParameters {
    /// Whether to tell last values, which may be large; as usual.
    pub values: Option<bool>,
}

/// Ports, and elements of multiple ones.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Ports {
    /// By component, in the order of its description.
    pub ports: Vec<Port>,
}

/// A port, or an element of a multiple one.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Port {
    /// `COMPONENT/PORT` or `COMPONENT/PORT/ELEMENT`.
    pub address: String,
    /// Its name in the description.
    pub name: String,
    /// Whether its component reads or writes it.
    pub direction: PortDirection,
    /// Whether it has elements; what each is connected to is told by element.
    pub multiple: bool,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Digest of its type: ports of one digest can be connected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
    /// Its documentation in the description.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doc: Option<String>,
    /// The out port that feeds it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub connected: Option<String>,
    /// Its middlewares.
    pub backend: BackendNames,
    /// What passed through it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub traffic: Option<Counts>,
    /// Its last value, if it ever had one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<Value>,
}

/// Whether a component reads or writes a port.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum PortDirection {
    /// It reads it.
    In,
    /// It writes it.
    Out,
}

/// What passed through a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Counts {
    /// Samples published, or new ones read.
    pub samples: u64,
    /// Samples that middlewares gave up.
    pub dropped: u64,
    /// Writes or reads that failed.
    pub failed: u64,
    /// Age of the last sample, in nanoseconds.
    pub age_ns: Option<u64>,
}

/// Counts from which rates are made, as differences between two readings. Dates are those of the
/// components' clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Traffic {
    /// What passed.
    #[serde(flatten)]
    pub counts: Counts,
    /// The date now, in nanoseconds.
    pub now_ns: u64,
    /// Date of the first sample.
    pub first_ns: Option<u64>,
    /// Date of the last sample.
    pub last_ns: Option<u64>,
    /// Sum of the squares of the intervals between samples, in (100 ns)^2, modulo 2^64.
    pub squares: u64,
    /// Samples of which `bytes` is the sum.
    pub weighed: u64,
    /// Bytes of those samples: in memory, or as CDR when their size varies.
    pub bytes: u64,
}

impl Traffic {
    /// Unit of the intervals whose squares are summed, in nanoseconds: sums of a day of them, or
    /// of one of minutes, fit 64 bits.
    pub const UNIT: u64 = 100;
}

/// Counts of a port.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PortTraffic {
    /// Its counts.
    #[serde(flatten)]
    pub traffic: Traffic,
    /// The port.
    pub address: String,
}

/// A value was published.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Published {
    /// The in port.
    pub address: String,
    /// The whole value.
    pub value: Value,
}
