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

/// Services that every component has and that are a supervisor's, each with the right that the
/// route of the same effect asks for.
pub const STANDARD_SERVICES: [(&str, Right); 5] = [
    ("kill", Right::Admin),
    ("connect_port", Right::Wire),
    ("connect_service", Right::Wire),
    ("connect_remote", Right::Wire),
    ("abort_activity", Right::Call),
];

impl Right {
    /// What calling one of the services takes that every component has.
    #[must_use]
    pub fn of_standard_service(name: &str) -> Self {
        let found = STANDARD_SERVICES.iter().find(|(service, _)| *service == name);
        found.map_or(Right::Call, |(_, right)| *right)
    }
}
