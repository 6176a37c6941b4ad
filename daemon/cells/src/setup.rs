//! What holds for all cells of a daemon.

use std::fs;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use genom_configuration::{CellSettings, Config, Deployment, Reaction};
use genom_protocol::Change;
use serde_json::Value;

use crate::place::Place;

/// What holds for all cells of a daemon.
pub struct Setup {
    /// The program that cells run: the daemon's own.
    pub program: PathBuf,
    /// The daemon's socket; directories of cells stand beside it.
    pub socket: PathBuf,
    /// The daemon's configuration; cells run by it, but for what is the daemon's alone.
    pub config: Config,
    /// When processes are restarted, and given up.
    pub settings: CellSettings,
    /// How long a component may take to stop.
    pub stop_timeout: Duration,
    /// Hears what cells tell, and what becomes of them.
    pub hears: Box<dyn Fn(Told) + Send + Sync>,
}

/// The configuration of a cell could not be written.
#[derive(Debug, thiserror::Error)]
pub(crate) enum WriteError {
    #[error(transparent)]
    Text(#[from] toml::ser::Error),
    #[error(transparent)]
    File(#[from] std::io::Error),
}

/// Something to be told on.
#[derive(Clone, Debug)]
pub enum Told {
    /// A change of a cell's own.
    Change(Value),
    /// An entry of a cell's log.
    Log(Value),
    /// What became of a cell.
    Cell(Change),
    /// A component failed, and something is to be done for that.
    Failed(Failure),
}

/// A component failed.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Its instance name.
    pub component: String,
    /// What is to be done.
    pub reactions: Vec<Reaction>,
    /// When the end of its process was seen.
    pub seen: Instant,
}

impl Setup {
    pub(crate) fn tell(&self, told: Told) {
        (self.hears)(told);
    }

    /// A process ended by a fault: tells what is to be done for the components that it held.
    pub(crate) fn failed(&self, held: &Deployment) {
        let seen = Instant::now();
        for component in held.component.iter().filter(|one| !one.on_failure.is_empty()) {
            let (component, reactions) = (component.instance(), component.on_failure.clone());
            self.tell(Told::Failed(Failure { component, reactions, seen }));
        }
    }

    /// Writes how a cell is to run: as the daemon, but with a socket of its own, and with what
    /// components hold in common with none but the daemon's on shared memory.
    pub(crate) fn write_config(&self, place: &Place) -> Result<(), WriteError> {
        let mut config = self.config.clone();
        config.component.clear();
        config.connection.clear();
        config.call.clear();
        config.activity.clear();
        config.rpc.socket = Some(place.socket());
        config.rpc.listen = None;
        config.rpc.tls = None;
        config.rpc.token_file = None;
        if config.backend == "local" {
            "shm".clone_into(&mut config.backend);
        }
        Ok(fs::write(place.config(), config.text()?)?)
    }
}
