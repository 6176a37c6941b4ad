//! What the daemon shall do: the configuration file, and the command line over it.

mod backends;
mod component;
mod deployment;
mod file;
mod overrides;

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

pub(crate) use backends::BackendNames;
pub(crate) use component::LoadRequest;
pub(crate) use deployment::{CallEntry, ConnectionEntry, Deployment};
pub(crate) use file::{Config, ConfigError};

use crate::cli::Cli;

/// Which time components live in.
#[derive(
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Eq,
    serde::Deserialize,
    serde::Serialize,
    clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub(crate) enum ClockKind {
    /// The machine's monotonic clock.
    #[default]
    Monotonic,
    /// One that stands still until a supervisor steps it: same inputs, same codel calls.
    Virtual,
}

/// Everything decided before anything starts.
#[derive(Clone, Debug)]
pub(crate) struct Settings {
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
    /// Time of the components.
    pub(crate) clock: ClockKind,
    /// Whether to keep all memory in RAM.
    pub(crate) lock_memory: bool,
    /// How long the start codel of a task may take before the component is refused.
    pub(crate) start_timeout: Duration,
    /// How long a component may take to stop before it is left behind.
    pub(crate) stop_timeout: Duration,
    /// The control plane.
    pub(crate) rpc: RpcSettings,
}

/// Where the control plane listens, and its limits.
#[derive(Clone, Debug)]
pub(crate) struct RpcSettings {
    /// Unix socket.
    pub(crate) socket: PathBuf,
    /// Loopback TCP address, if asked for.
    pub(crate) listen: Option<SocketAddr>,
    /// Greatest size of a request's body, in bytes.
    pub(crate) max_body: usize,
    /// Connections served at a time; more wait.
    pub(crate) max_connections: usize,
    /// Open streams at a time; more are refused.
    pub(crate) max_streams: usize,
    /// How long the result of an ended activity stays readable.
    pub(crate) keep_results: Duration,
}

/// The command line contradicts itself or the configuration.
#[derive(Debug, thiserror::Error)]
pub(crate) enum UsageError {
    /// `--name` or `--gen` with none or several components.
    #[error("{option} goes with exactly one component, {found} are given")]
    OneComponent { option: &'static str, found: usize },
    /// `--listen` on an address that others can reach.
    #[error(
        "{0} can be reached from outside, and requests are not authenticated: \
         listen on 127.0.0.1 or [::1]"
    )]
    NotLoopback(SocketAddr),
}

impl Settings {
    /// The command line over the configuration.
    pub(crate) fn new(cli: Cli, config: Config) -> Result<Self, UsageError> {
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
        let listen = cli.listen.or(config.rpc.listen);
        if let Some(address) = listen.filter(|address| !address.ip().is_loopback()) {
            return Err(UsageError::NotLoopback(address));
        }
        let mut deployment = Deployment::of(&config, cli.daemon.as_deref());
        deployment.component.extend(components);
        let rpc = RpcSettings {
            socket: cli.socket.or(config.rpc.socket).unwrap_or_else(default_socket),
            listen,
            max_body: config.rpc.max_body,
            max_connections: config.rpc.max_connections,
            max_streams: config.rpc.max_streams,
            keep_results: Duration::from_secs(config.rpc.keep_results),
        };
        Ok(Self {
            backend: cli.backend.unwrap_or(config.backend),
            deployment,
            name: cli.daemon,
            path: [cli.path, cli.genom_path, config.path].concat(),
            include: [cli.include, config.include].concat(),
            log: cli.log.unwrap_or(config.log),
            backends: config.backends,
            clock: cli.clock.unwrap_or(config.clock),
            lock_memory: config.lock_memory,
            start_timeout: Duration::from_secs(config.start_timeout),
            stop_timeout: Duration::from_secs(config.stop_timeout),
            rpc,
        })
    }
}

/// Where a daemon of this user listens when nothing else is said; `genomctl` has the same rule.
fn default_socket() -> PathBuf {
    match std::env::var_os("XDG_RUNTIME_DIR").filter(|dir| !dir.is_empty()) {
        Some(dir) => PathBuf::from(dir).join("genomd.sock"),
        None => {
            let user = rustix::process::getuid().as_raw();
            PathBuf::from(format!("/tmp/genomd-{user}/genomd.sock"))
        }
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
    fn a_name_goes_with_one_component() {
        let one = settings(&["--name", "arm", "demo.so"]).unwrap();
        assert_eq!(one.deployment.component[0].name.as_deref(), Some("arm"));
        let two = settings(&["--name", "arm", "a.so", "b.so"]).unwrap_err();
        assert_eq!(two, "--name goes with exactly one component, 2 are given");
    }

    #[test]
    fn only_loopback_is_listened_on() {
        assert!(settings(&["--listen", "127.0.0.1:0"]).is_ok());
        assert!(settings(&["--listen", "[::1]:0"]).is_ok());
        let refused = settings(&["--listen", "0.0.0.0:7000"]).unwrap_err();
        assert!(refused.contains("0.0.0.0:7000 can be reached from outside"), "{refused}");
    }
}
