//! What holds for all cells of a daemon.

use std::fs::DirBuilder;
use std::io;
use std::os::unix::fs::DirBuilderExt as _;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;
use std::time::{Duration, Instant};

use genom_configuration::{CellLimits, CellSettings, Config, Reaction};
use genom_protocol::Change;
use genom_protocol::freeze::MOST;
use genom_supervisor::bus::Teller;
use genom_supervisor::connections::between_processes;
use rustix::process::Signal;
use serde_json::Value;

use crate::blackbox::BlackBoxes;
use crate::crashes::Reports;
use crate::done::Doing;
use crate::end::End;
use crate::place::Place;
use crate::program::in_runner;
use crate::theirs;

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
    /// Reports of those that crashed.
    pub reports: Reports,
    /// What they did last.
    pub boxes: Arc<BlackBoxes>,
    /// How long a component may take to stop.
    pub stop_timeout: Duration,
    /// Whether the daemon is part of a program, which steps it and its cells.
    pub embedded: bool,
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
    /// A change of a cell's own, with who told it: no one, if its process left it and has ended.
    Change(Value, Option<Teller>),
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
    /// When that was seen.
    pub seen: Instant,
    /// How it failed.
    pub cause: Cause,
    /// Held until all of it is done, where somebody waits for that.
    pub under_way: Option<Doing>,
}

/// How a component failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The process of its cell ended.
    Ended,
    /// It broke a rule of its supervision.
    BrokenRule,
}

impl Cause {
    /// The key of the configuration that says what is to be done.
    pub(crate) fn key(self) -> &'static str {
        match self {
            Self::Ended => "on_failure",
            Self::BrokenRule => "supervision",
        }
    }
}

impl Setup {
    /// What starts a process of the cell with files at this place.
    pub(crate) fn command(&self, place: &Place) -> Command {
        match place.runner() {
            Some(command) => in_runner(&command),
            None => Command::new(&self.program),
        }
    }

    pub(crate) fn tell(&self, told: Told) {
        (self.hears)(told);
    }

    /// Writes how a cell is to run: as the daemon, but with a socket of its own, and with what
    /// components hold in common with none but the daemon's on shared memory.
    pub(crate) fn write_config(&self, name: &str, place: &Place) -> Result<(), WriteError> {
        Ok(theirs::write(&place.config(), self.config_of(name, place)?.as_bytes())?)
    }

    /// Whether what runs there was configured as it would be now.
    pub(crate) fn wrote_config(&self, name: &str, place: &Place) -> bool {
        let wanted = self.config_of(name, place).ok();
        let most = wanted.as_ref().map_or(0, |text| text.len() as u64);
        theirs::read(&place.config(), most).ok().is_some_and(|text| Some(text) == wanted)
    }

    fn config_of(&self, name: &str, place: &Place) -> Result<String, WriteError> {
        let mut config = self.config.clone();
        // Relative ones are found from the daemon's directory, not from that of the cell's file.
        config.path.iter_mut().chain(&mut config.include).for_each(make_absolute);
        config.cells.limits = self.limits(name, place)?;
        config.cell.clear();
        config.component.clear();
        config.connection.clear();
        config.call.clear();
        config.activity.clear();
        config.rpc.socket = Some(place.socket());
        config.rpc.listen = None;
        config.web.listen = None;
        config.foxglove.listen = None;
        config.lifecycle.components.clear();
        config.rpc.tls = None;
        config.rpc.token_file = None;
        if let Some(middleware) = genom_gateway::middleware_of(name) {
            middleware.clone_into(&mut config.backend);
            config.gateways.of.clear();
        }
        // Relative to the daemon's directory.
        let daemon = std::path::absolute(&self.socket)?;
        config.gateways.daemon = Some(config.gateways.daemon.unwrap_or(daemon));
        // Components come with their state when a system is thawed.
        config.rpc.max_body = config.rpc.max_body.max(MOST);
        config.backend = between_processes(&config.backend.as_str().into()).to_string();
        Ok(config.text()?)
    }

    /// What holds for cells does not for gateways, which need the network: they have sections of
    /// their own.
    fn limits_of(&self, name: &str) -> CellLimits {
        match genom_gateway::middleware_of(name) {
            Some(_) => self.config.cell.get(name).cloned().unwrap_or_default(),
            None => self.config.limits_of(name),
        }
    }

    /// What a cell may use. In a sandbox it reads its libraries, and has temporary files of its
    /// own.
    fn limits(&self, name: &str, place: &Place) -> io::Result<CellLimits> {
        let mut limits = self.limits_of(name);
        limits.read.iter_mut().chain(&mut limits.write).flatten().for_each(make_absolute);
        if limits.is_sandbox() {
            let granted = limits.read.get_or_insert_default();
            granted.extend(place.granted().into_iter().filter(|path| path.exists()));
            DirBuilder::new().recursive(true).mode(0o700).create(place.temporary())?;
        }
        Ok(limits)
    }

    /// How a cell ended, with the limit that it may have reached.
    pub(crate) fn explain(&self, name: &str, end: &End) -> String {
        let limits = self.limits_of(name);
        let End::Signal(signal) = end else { return end.to_string() };
        let memory = [Signal::ABORT, Signal::SEGV, Signal::BUS];
        match (limits.memory, limits.rttime) {
            (_, Some(most)) if *signal == Signal::XCPU.as_raw() => {
                format!("{end}: a real-time thread ran for rttime = {most} ms without waiting")
            }
            (Some(most), _) if memory.iter().any(|one| one.as_raw() == *signal) => {
                format!("{end}; its memory is limited to {most} MiB")
            }
            _ => end.to_string(),
        }
    }
}

fn make_absolute(path: &mut PathBuf) {
    if let Ok(absolute) = std::path::absolute(&*path) {
        *path = absolute;
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn the_limit_that_ended_a_cell_is_told() {
        let config = "[cell.arm]\nmemory = 64\nrttime = 20\n";
        let setup = Setup {
            program: PathBuf::new(),
            reports: Reports::new(
                &genom_configuration::CrashesSection::default(),
                std::path::Path::new("/s"),
            ),
            boxes: Arc::new(BlackBoxes::new(&genom_configuration::BlackBoxSection::default())),
            socket: PathBuf::new(),
            config: Config::parse(Path::new("robot.toml"), config).unwrap(),
            settings: CellSettings::default(),
            stop_timeout: Duration::from_secs(1),
            embedded: false,
            hears: Box::new(drop),
        };
        let told = |name, signal: Signal| setup.explain(name, &End::Signal(signal.as_raw()));
        assert!(told("arm", Signal::XCPU).ends_with("rttime = 20 ms without waiting"));
        assert!(told("arm", Signal::ABORT).ends_with("limited to 64 MiB"));
        assert_eq!(told("other", Signal::ABORT), "signal 6 (SIGABRT)");
    }
}
