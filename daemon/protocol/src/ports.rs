//! Ports: their connections, values and counters.

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
    /// Name of the element, if the port is multiple.
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
    /// Whether to include last values, which may be large; true by default.
    pub values: Option<bool>,
}

/// Ports, and the elements of multiple ones.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Ports {
    /// The ports, by component, in the order of its description.
    pub ports: Vec<Port>,
}

/// A port, or an element of a multiple one.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Port {
    /// `COMPONENT/PORT` or `COMPONENT/PORT/ELEMENT`.
    pub address: String,
    /// Name of the port in the description.
    pub name: String,
    /// Whether its component reads (`in`) or writes (`out`) it.
    pub direction: PortDirection,
    /// Whether it has elements; each of these is listed with its own connection.
    pub multiple: bool,
    /// Name of its type.
    #[serde(rename = "type")]
    pub ty: String,
    /// Digest of its type; ports of equal digest can be connected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub digest: Option<String>,
    /// Its documentation in the description.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doc: Option<String>,
    /// Address of the out port that it reads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub connected: Option<String>,
    /// The middleware of that connection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub over: Option<String>,
    /// Its middlewares; those of an in port say where it looks for writers of other daemons.
    pub backend: BackendNames,
    /// Counters of its samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub traffic: Option<Counts>,
    /// Its last value; absent if it never had one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<Value>,
}

/// Direction of a port, seen from its component.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum PortDirection {
    /// The component reads it.
    In,
    /// The component writes it.
    Out,
}

/// Counters of a port.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Counts {
    /// Samples published, or new samples read.
    pub samples: u64,
    /// Samples that middlewares dropped.
    pub dropped: u64,
    /// Writes or reads that failed.
    pub failed: u64,
    /// Time since the last sample, in nanoseconds.
    pub age_ns: Option<u64>,
}

/// Counters from which rates are computed, as differences between two readings. Dates are those of
/// the components' clock, in nanoseconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Traffic {
    /// Counters of samples.
    #[serde(flatten)]
    pub counts: Counts,
    /// Date of this reading.
    pub now_ns: u64,
    /// Date of the first sample.
    pub first_ns: Option<u64>,
    /// Date of the last sample.
    pub last_ns: Option<u64>,
    /// Sum of the squares of the intervals between samples, in (100 ns)², modulo 2⁶⁴.
    pub squares: u64,
    /// Number of samples that `bytes` counts.
    pub weighed: u64,
    /// Total size of these samples: in memory, or as CDR if the size varies.
    pub bytes: u64,
}

impl Traffic {
    /// Unit of the intervals whose squares are summed, in nanoseconds. With it the sums for samples
    /// of a day, or for intervals of minutes, fit in 64 bits.
    pub const UNIT: u64 = 100;
}

/// Counters of a port.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct PortTraffic {
    /// The counters.
    #[serde(flatten)]
    pub traffic: Traffic,
    /// Address of the port.
    pub address: String,
}

/// A value was published.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Published {
    /// Address of the in port.
    pub address: String,
    /// The complete value, including members that the request left out.
    pub value: Value,
}
