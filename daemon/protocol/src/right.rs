//! Rights of users of the control plane.

use serde::{Deserialize, Serialize};
use strum::{Display, EnumString};

/// What the holder of a token may do.
#[derive(
    Clone, Copy, Debug, Display, EnumString, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum Right {
    /// Read: components, values, statistics, events.
    Read,
    /// Call services, abort activities, fire events, publish to in ports, step the clock.
    Call,
    /// Connect, disconnect, and move ports between middlewares.
    Wire,
    /// Everything, including loading, unloading, deploying and stopping the daemon.
    Admin,
}
