//! Section `[gateways]`: middlewares that run in processes of their own.

use std::path::PathBuf;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::error::UsageError;

/// Section `[gateways]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GatewaysSection {
    /// Names of these middlewares; by default all that others on the network can reach.
    pub of: Vec<String>,
    /// Socket of the daemon that starts them; by default this daemon's own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub daemon: Option<PathBuf>,
    /// The longest delay in seconds before one that ran starts again.
    pub restart_delay_max: f64,
}

/// What the longest delay may be, in seconds: a gateway that ends again and again is not to take a
/// processor for its starts.
const DELAYS: std::ops::RangeInclusive<f64> = 0.05..=86_400.0;

/// The longest delay by default, in seconds: the network flows again within a second, its start
/// and the discovery of others included.
const DELAY: f64 = 0.25;

impl Default for GatewaysSection {
    fn default() -> Self {
        // Those of libraries are added when they are found.
        let all = genom_registry::known().iter();
        let all = all.filter(|known| known.gateway && known.library().is_none());
        let of = all.map(|known| known.name.to_owned()).collect();
        Self { of, daemon: None, restart_delay_max: DELAY }
    }
}

impl GatewaysSection {
    /// Checks that there can be gateways of these middlewares, and the delay.
    ///
    /// # Errors
    /// One is unknown, or does not leave this machine, or the delay is none.
    pub fn check(&self) -> Result<(), UsageError> {
        if !DELAYS.contains(&self.restart_delay_max) {
            let (least, most) = (*DELAYS.start(), *DELAYS.end());
            return Err(UsageError::GatewayDelay { value: self.restart_delay_max, least, most });
        }
        let each = self.of.iter().try_for_each(|name| genom_registry::check_gateway(name));
        each.map_err(|error| UsageError::Gateway(error.to_string()))
    }
    /// The longest delay before one that ran starts again.
    #[must_use]
    pub fn longest_delay(&self) -> Duration {
        Duration::from_secs_f64(if DELAYS.contains(&self.restart_delay_max) {
            self.restart_delay_max
        } else {
            DELAY
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_with_which_gateways_take_a_processor_is_refused() {
        for wrong in [0.0, 0.049, f64::NAN] {
            let section = GatewaysSection { restart_delay_max: wrong, ..Default::default() };
            let refused = section.check().unwrap_err().to_string();
            let told = format!("gateways.restart_delay_max = {wrong}: 0.05 to 86400 seconds");
            assert_eq!(refused, told);
        }
        GatewaysSection::default().check().unwrap();
    }
}
