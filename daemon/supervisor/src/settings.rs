//! What holds for all components of a supervisor.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Duration;

use genom_configuration::{ClockKind, Config, Offers};

/// What holds for all components of a supervisor.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Middleware of components that name none.
    pub backend: String,
    /// Options of middlewares, by name.
    pub backends: BTreeMap<String, toml::Table>,
    /// Where to look for components named without a directory.
    pub path: Vec<PathBuf>,
    /// Where to look for what descriptions include.
    pub include: Vec<PathBuf>,
    /// Time of the components.
    pub clock: ClockKind,
    /// How long the start codel of a task may take before the component is refused.
    pub start_timeout: Duration,
    /// How long a component may take to stop before it is left behind.
    pub stop_timeout: Duration,
    /// How long a codel may run before it counts as stuck, where no period says more.
    pub stuck_after: Duration,
    /// Activities of services that one task runs at once.
    pub max_activities: usize,
    /// How long the result of an ended activity stays readable.
    pub keep_results: Duration,
    /// Which services are offered on which middlewares.
    pub offers: Offers,
}

impl From<Config> for Settings {
    fn from(config: Config) -> Self {
        Self {
            backend: config.backend,
            backends: config.backends,
            path: config.path,
            include: config.include,
            clock: config.clock,
            start_timeout: Duration::from_secs(config.start_timeout),
            stop_timeout: Duration::from_secs(config.stop_timeout),
            stuck_after: Duration::from_secs(config.stuck_after),
            max_activities: config.max_activities,
            keep_results: Duration::from_secs(config.rpc.keep_results),
            offers: config.services,
        }
    }
}

impl Default for Settings {
    /// Those of a configuration that says nothing.
    fn default() -> Self {
        Config::default().into()
    }
}
