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
pub enum Right {
    /// Read: components, values, statistics, events.
    Read,
    /// Also call services, abort activities, fire events, publish to in ports, step the clock.
    Call,
    /// Also connect, disconnect, and move ports between middlewares.
    Wire,
    /// Everything, including loading, unloading, deploying and stopping the daemon.
    Admin,
}

/// The services that every component has and that act as a supervisor does, each with the right
/// that the route of the same effect requires.
pub const STANDARD_SERVICES: [(&str, Right); 5] = [
    ("kill", Right::Admin),
    ("connect_port", Right::Wire),
    ("connect_service", Right::Wire),
    ("connect_remote", Right::Wire),
    ("abort_activity", Right::Call),
];

impl Right {
    /// The right required to call one of the services that every component has.
    #[must_use]
    pub fn of_standard_service(name: &str) -> Self {
        let found = STANDARD_SERVICES.iter().find(|(service, _)| *service == name);
        found.map_or(Right::Call, |(_, right)| *right)
    }
}
