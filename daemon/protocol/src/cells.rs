//! Cells: processes of their own for components, so that a fault stays in one of them.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use strum::{Display, EnumString};

/// Whether a component is brought up again when the process of its cell has ended.
#[derive(
    Clone, Copy, Debug, Default, Display, EnumString, PartialEq, Eq, Deserialize, Serialize,
)]
#[serde(rename_all = "kebab-case")]
#[strum(serialize_all = "kebab-case")]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum RestartPolicy {
    /// It stays down.
    Never,
    /// After a signal, an exit status other than 0, or a cell that no longer answered.
    #[default]
    OnFailure,
    /// Whatever the reason, unless somebody asked for the end.
    Always,
}

impl RestartPolicy {
    /// Whether this is what holds when nothing is said.
    #[must_use]
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

/// The cells of a daemon.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Cells {
    /// By name.
    pub cells: Vec<Cell>,
}

/// A process of the daemon's that runs components.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Cell {
    /// Its name.
    pub name: String,
    /// How it is.
    pub state: CellState,
    /// Its process, while it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pid: Option<u32>,
    /// Components in it, or that it is to have when it is back.
    pub components: Vec<String>,
    /// How often its process was started by this daemon.
    pub starts: u64,
    /// How its last process ended: `signal 11 (SIGSEGV)`, `exit status 1`, ...
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last_end: Option<String>,
    /// The private socket on which it answers.
    #[cfg_attr(feature = "openapi", schema(value_type = String))]
    pub socket: PathBuf,
}

/// How a cell is.
#[derive(Clone, Copy, Debug, Display, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
#[strum(serialize_all = "lowercase")]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub enum CellState {
    /// Its process loads what it is to hold.
    Starting,
    /// It answers.
    Running,
    /// Its process has ended; the next one starts after the back-off.
    Waiting,
    /// Its process ended too often within the window, or nothing in it is to be restarted.
    Failed,
    /// Somebody asked for its end.
    Stopping,
}

/// The cell's process is asked to end, or was.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct CellEnds {
    /// Its name.
    pub cell: String,
}
