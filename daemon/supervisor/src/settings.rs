//! Settings that apply to all components of a supervisor.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use genom_configuration::{ClockKind, Config, ExecutionKind, Offers, ReloadSection};
use genom_registry::Gateways;

/// Settings that apply to all components of a supervisor.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Default middleware, for components that name none.
    pub backend: String,
    /// Options of middlewares, by name of the middleware.
    pub backends: BTreeMap<String, toml::Table>,
    /// Middlewares in processes of their own.
    pub gateways: Option<Gateways>,
    /// Directories searched for components.
    pub path: Vec<PathBuf>,
    /// Directories searched for files that descriptions include.
    pub include: Vec<PathBuf>,
    /// The clock of the components.
    pub clock: ClockKind,
    /// Whether that is the time of a simulator on ROS 2; in a cell, which its daemon steps, too.
    pub simulated: bool,
    /// Which threads execute the components.
    pub execution: ExecutionKind,
    /// Whether components are reloaded when their files change.
    pub watch: bool,
    /// How long the start codel of a task may take before loading fails.
    pub start_timeout: Duration,
    /// How long a component may take to stop before it is left behind.
    pub stop_timeout: Duration,
    /// How long a codel may run before it counts as stuck, unless its period is longer.
    pub stuck_after: Duration,
    /// Activities that one task may run at once.
    pub max_activities: usize,
    /// How long the result of an ended activity is kept.
    pub keep_results: Duration,
    /// Where is kept what components ran before a reload, until the new library has proved itself;
    /// set in a cell.
    pub trials: Option<Trials>,
    /// How long a new library is on trial, and what takes it back.
    pub reload: ReloadSection,
    /// Which services are offered on which middlewares.
    pub offers: Offers,
}

/// How new libraries are tried in a cell.
#[derive(Clone, Debug)]
pub struct Trials {
    /// Where is kept what ran before.
    pub place: PathBuf,
    /// The program that loads a library beforehand (`genomd --check`); without, none does.
    pub program: Option<PathBuf>,
}

impl From<Config> for Settings {
    fn from(config: Config) -> Self {
        Self {
            backend: config.backend,
            backends: config.backends,
            // Who starts their processes is not in the file.
            gateways: None,
            path: config.path,
            include: config.include,
            clock: config.clock,
            simulated: config.clock == ClockKind::Ros,
            execution: config.execution,
            watch: config.watch,
            start_timeout: Duration::from_secs(config.start_timeout),
            stop_timeout: Duration::from_secs(config.stop_timeout),
            stuck_after: Duration::from_secs(config.stuck_after),
            max_activities: config.max_activities,
            keep_results: Duration::from_secs(config.rpc.keep_results),
            trials: None,
            reload: config.reload,
            offers: config.services,
        }
    }
}

impl Default for Settings {
    /// The settings of an empty configuration.
    fn default() -> Self {
        Config::default().into()
    }
}
