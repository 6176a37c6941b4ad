//! What the daemon shall do: the configuration file, and the command line over it.

mod error;
mod file;
mod offers;
mod overrides;
pub(crate) mod place;
mod rpc;
mod spot;
pub(crate) mod terms;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

pub(crate) use error::{ConfigError, WhichDaemon};
pub(crate) use file::Config;
pub(crate) use genom_protocol::{
    BackendNames, CallEntry, ClockKind, ConnectionEntry, Deployment, LoadRequest, QosEntry, Right,
};
pub(crate) use offers::Offers;
pub(crate) use rpc::{RpcSettings, Tls};
pub(crate) use spot::Spot;

use crate::cli::Cli;
use crate::logs;
use crate::telemetry::Collector;

/// Everything decided before anything starts.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
    /// The configuration file, for messages.
    pub(crate) file: Option<PathBuf>,
    /// Default middleware.
    pub(crate) backend: String,
    /// What to bring up: components first, those of the command line last among them.
    pub(crate) deployment: Deployment,
    /// Which daemon of a file that describes several this one is.
    pub(crate) name: Option<String>,
    /// Where to look for components named without a directory.
    pub(crate) path: Vec<PathBuf>,
    /// `-I` of the descriptions.
    pub(crate) include: Vec<PathBuf>,
    /// What to log.
    pub(crate) log: String,
    /// Options of middlewares, by name.
    pub(crate) backends: BTreeMap<String, toml::Table>,
    /// Whether to go on when the terminal is closed.
    pub(crate) keep: bool,
    /// Time of the components.
    pub(crate) clock: ClockKind,
    /// Whether to keep all memory in RAM.
    pub(crate) lock_memory: bool,
    /// When to look whether codels wrote past their memory.
    pub(crate) check_memory: genom_host::MemoryCheck,
    /// How long the start codel of a task may take before the component is refused.
    pub(crate) start_timeout: Duration,
    /// How long a component may take to stop before it is left behind.
    pub(crate) stop_timeout: Duration,
    /// How long a codel may run before it counts as stuck, where no period says more.
    pub(crate) stuck_after: Duration,
    /// Activities of services that one task runs at once.
    pub(crate) max_activities: usize,
    /// Where spans go, if anywhere.
    pub(crate) collector: Option<Collector>,
    /// The control plane.
    pub(crate) rpc: RpcSettings,
    /// Which services are offered on which middlewares.
    pub(crate) offers: Offers,
}

/// Most activities that a task may be allowed at once: room for all is made when it starts.
const MOST_ACTIVITIES: usize = 4096;

/// The command line contradicts itself or the configuration.
#[derive(Debug, thiserror::Error)]
pub(crate) enum UsageError {
    /// `--name` or `--gen` with none or several components.
    #[error("{option} goes with exactly one component, {found} are given")]
    OneComponent { option: &'static str, found: usize },
    /// `--listen` on an address that others can reach, in the clear.
    #[error(
        "{0} can be reached from outside: it needs TLS, `cert` and `key` in section [rpc.tls] of \
         the configuration, and tokens or client certificates; or listen on 127.0.0.1 or [::1]"
    )]
    NoTls(SocketAddr),
    /// `--listen`, and nothing says who may come in.
    #[error(
        "whoever reaches {0} could command this daemon: say with --token-file FILE who may \
         (`genomctl token NAME --into FILE` begins one), or with rpc.tls.client_ca"
    )]
    Anybody(SocketAddr),
    /// Nobody could come in, not even to stop it.
    #[error("rpc.max_connections = 0: the daemon would answer nobody; one at least")]
    NoConnections,
    /// No activity could start, or each task had room made for more than there will ever be.
    #[error("max_activities = {0}: give 1 to {MOST_ACTIVITIES}")]
    Activities(usize),
    /// A pattern of `[services]` that nothing is like.
    #[error(
        "[services]: `{0}` is no pattern of services: write BACKEND:COMPONENT/SERVICE or \
         COMPONENT/SERVICE, with * for anything, such as zenoh:*/kill"
    )]
    Offer(String),
    /// A file for several daemons.
    #[error("{}: {why}", file.display())]
    Daemon { file: PathBuf, why: WhichDaemon },
    /// `log` is no filter.
    #[error("--log {0}")]
    Log(String),
    /// `telemetry.otlp` is no place to send to.
    #[error("{0}")]
    Collector(String),
}

impl Settings {
    /// The command line over the configuration.
    pub(crate) fn new(cli: Cli, config: Config) -> Result<Self, UsageError> {
        let config = config.over(&cli);
        let rpc = RpcSettings::new(config.rpc.clone())?;
        config.services.check()?;
        if !(1..=MOST_ACTIVITIES).contains(&config.max_activities) {
            return Err(UsageError::Activities(config.max_activities));
        }
        let mut components: Vec<_> = cli
            .components
            .into_iter()
            .map(|library| LoadRequest { library, ..LoadRequest::default() })
            .collect();
        let found = components.len();
        for (option, given) in [("--name", cli.name.is_some()), ("--gen", cli.gen_file.is_some())] {
            if given && found != 1 {
                return Err(UsageError::OneComponent { option, found });
            }
        }
        if let Some(only) = components.first_mut().filter(|_| found == 1) {
            only.name = cli.name;
            only.gen_file = cli.gen_file;
        }
        logs::understood(&config.log).map_err(UsageError::Log)?;
        let deployment = config.deployment(cli.daemon.as_deref());
        let mut deployment = deployment.map_err(|why| {
            let file = cli.config.clone().unwrap_or_default();
            UsageError::Daemon { file, why }
        })?;
        deployment.component.extend(components);
        let collector = config.telemetry.otlp.as_deref().map(Collector::parse).transpose();
        let collector = collector.map_err(UsageError::Collector)?;
        Ok(Self {
            file: cli.config,
            collector,
            backend: config.backend,
            deployment,
            name: cli.daemon,
            path: config.path,
            include: config.include,
            log: config.log,
            backends: config.backends,
            keep: cli.keep,
            clock: config.clock,
            lock_memory: config.lock_memory,
            check_memory: config.check_memory.host(),
            start_timeout: Duration::from_secs(config.start_timeout),
            stop_timeout: Duration::from_secs(config.stop_timeout),
            stuck_after: Duration::from_secs(config.stuck_after),
            max_activities: config.max_activities,
            rpc,
            offers: config.services,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser as _;

    fn settings(arguments: &[&str]) -> Result<Settings, String> {
        let cli = Cli::try_parse_from(std::iter::once(&"genomd").chain(arguments)).unwrap();
        Settings::new(cli, Config::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn the_clock_that_is_dumped_is_the_one_that_runs() {
        let cli = Cli::try_parse_from(["genomd", "--clock", "virtual"]).unwrap();
        let text = Config::default().over(&cli).text().unwrap();
        assert!(text.contains("clock = \"virtual\""), "{text}");
        assert_eq!(settings(&["--clock", "virtual"]).unwrap().clock, ClockKind::Virtual);
    }

    #[test]
    fn a_name_goes_with_one_component() {
        let one = settings(&["--name", "arm", "demo.so"]).unwrap();
        assert_eq!(one.deployment.component[0].name.as_deref(), Some("arm"));
        let two = settings(&["--name", "arm", "a.so", "b.so"]).unwrap_err();
        assert_eq!(two, "--name goes with exactly one component, 2 are given");
    }
}
