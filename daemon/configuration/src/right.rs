//! Rights to do something through the control plane.

use std::fmt;

use serde::{Deserialize, Serialize};

/// What a token may be good for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Right {
    /// Look: components, values, statistics, what changes.
    Read,
    /// Act: services, activities, events, values of in ports, steps of the clock.
    Call,
    /// Connect, disconnect, move between middlewares.
    Wire,
    /// Load, unload, deploy, stop the daemon. Holds the other rights too.
    Admin,
}

impl Right {
    /// The right of that name.
    pub fn named(name: &str) -> Option<Self> {
        [Self::Read, Self::Call, Self::Wire, Self::Admin]
            .into_iter()
            .find(|right| right.to_string() == name)
    }
}

impl fmt::Display for Right {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Read => "read",
            Self::Call => "call",
            Self::Wire => "wire",
            Self::Admin => "admin",
        })
    }
}
