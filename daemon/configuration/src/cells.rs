//! Section `[cells]`: when the processes of cells are restarted, and given up.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::error::UsageError;
use crate::limits::CellLimits;

/// Section `[cells]`, as it is written: times in seconds.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct CellsSection {
    /// Before the first restart.
    pub restart_delay: f64,
    /// How much longer before each further one within the window.
    pub restart_factor: f64,
    /// The longest.
    pub restart_delay_max: f64,
    /// Restarts within the window; one more end, and the cell has failed.
    pub restart_most: usize,
    /// The window.
    pub restart_window: f64,
    /// How long a cell may take until it has loaded what it is to hold.
    pub ready_timeout: f64,
    /// How long a cell may answer nothing.
    pub alive_timeout: f64,
    /// What cells do when the daemon ends without having stopped them.
    pub without_daemon: WithoutDaemon,
    /// The interpreter that runs codels in Python.
    pub python: String,
    /// What each cell may use.
    pub limits: CellLimits,
}

/// What cells do when the daemon ends without having stopped them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WithoutDaemon {
    /// They go on; the next daemon on the same socket takes them over.
    #[default]
    Continue,
    /// They stop.
    Stop,
}

impl Default for CellsSection {
    fn default() -> Self {
        Self {
            restart_delay: 0.02,
            restart_factor: 4.0,
            restart_delay_max: 10.0,
            restart_most: 5,
            restart_window: 60.0,
            ready_timeout: 60.0,
            alive_timeout: 5.0,
            without_daemon: WithoutDaemon::Continue,
            python: "python3".to_owned(),
            limits: CellLimits::default(),
        }
    }
}

/// The same, checked.
#[derive(Clone, Debug, PartialEq)]
pub struct CellSettings {
    /// Before the first restart.
    pub restart_delay: Duration,
    /// How much longer before each further one within the window.
    pub restart_factor: f64,
    /// The longest.
    pub restart_delay_max: Duration,
    /// Restarts within the window.
    pub restart_most: usize,
    /// The window.
    pub restart_window: Duration,
    /// How long a cell may take to be ready.
    pub ready_timeout: Duration,
    /// How long a cell may answer nothing.
    pub alive_timeout: Duration,
}

/// The longest of these times, in seconds.
const LONGEST: f64 = 86_400.0;

impl CellSettings {
    /// Checks a section.
    ///
    /// # Errors
    /// A time or factor is none.
    pub fn new(section: &CellsSection) -> Result<Self, UsageError> {
        let refuse = |key: &str, value: f64, what: &str| UsageError::Cells {
            key: key.to_owned(),
            value,
            what: what.to_owned(),
        };
        let time = |key: &str, seconds: f64, least: f64| {
            if (least..=LONGEST).contains(&seconds) {
                Ok(Duration::from_secs_f64(seconds))
            } else {
                Err(refuse(key, seconds, &format!("{least} to {LONGEST} seconds")))
            }
        };
        let factor = section.restart_factor;
        if !(1.0..=1000.0).contains(&factor) {
            return Err(refuse("restart_factor", factor, "1 to 1000"));
        }
        Ok(Self {
            restart_delay: time("restart_delay", section.restart_delay, 0.0)?,
            restart_factor: factor,
            restart_delay_max: time("restart_delay_max", section.restart_delay_max, 0.0)?,
            restart_most: section.restart_most,
            restart_window: time("restart_window", section.restart_window, 0.001)?,
            ready_timeout: time("ready_timeout", section.ready_timeout, 0.1)?,
            alive_timeout: time("alive_timeout", section.alive_timeout, 0.1)?,
        })
    }
}

impl Default for CellSettings {
    fn default() -> Self {
        Self {
            restart_delay: Duration::from_millis(20),
            restart_factor: 4.0,
            restart_delay_max: Duration::from_secs(10),
            restart_most: 5,
            restart_window: Duration::from_secs(60),
            ready_timeout: Duration::from_secs(60),
            alive_timeout: Duration::from_secs(5),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_section_and_what_it_means_have_the_same_defaults() {
        assert_eq!(CellSettings::new(&CellsSection::default()).unwrap(), CellSettings::default());
    }

    #[test]
    fn what_is_no_time_is_refused_by_its_key() {
        let section = CellsSection { alive_timeout: f64::NAN, ..CellsSection::default() };
        let refused = CellSettings::new(&section).unwrap_err().to_string();
        assert_eq!(refused, "cells.alive_timeout = NaN: 0.1 to 86400 seconds");
        let section = CellsSection { restart_factor: 0.5, ..CellsSection::default() };
        let refused = CellSettings::new(&section).unwrap_err().to_string();
        assert_eq!(refused, "cells.restart_factor = 0.5: 1 to 1000");
    }
}
