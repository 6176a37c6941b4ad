//! Rights to do something through the control plane.

use serde::{Deserialize, Serialize};
use strum::{Display, EnumString};

/// What a token is good for.
#[derive(
    Clone, Copy, Debug, Display, EnumString, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize,
)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
pub enum Right {
    /// Look: components, values, statistics, what changes.
    Read,
    /// Act: services, activities, events, values of in ports, steps of the clock.
    Call,
    /// Connect, disconnect, move between middlewares.
    Wire,
    /// Load, unload, deploy, stop the daemon; and all the others.
    Admin,
}
