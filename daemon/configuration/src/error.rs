//! What is wrong with a configuration, and where.

use std::net::SocketAddr;
use std::path::PathBuf;

use genom_nearest::nearest_key;

/// Most activities that a task may be allowed at once: room for all is made when it starts.
pub const MOST_ACTIVITIES: usize = 4096;

/// The command line contradicts itself or the configuration.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum UsageError {
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
    Log(#[from] NoLevel),
    /// `telemetry.otlp` is no place to send to.
    #[error("telemetry.otlp: {0}: write http://HOST:4318")]
    Collector(#[from] NoCollector),
}

/// Spans of services cannot be sent there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what they hold")]
pub enum NoCollector {
    #[error("`{0}` is no URL")]
    NoUrl(String),
    #[error("`{0}` is no http URL")]
    NotHttp(String),
    #[error("`{0}` names no host")]
    NoHost(String),
}

/// A configuration file cannot be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum ConfigError {
    /// Missing or unreadable.
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// A mistake in it.
    #[error("{}:{line}: {message}{}", path.display(), suggestion(.nearest))]
    Mistake { path: PathBuf, line: usize, message: String, nearest: Option<String> },
    /// A mistake in `--set`.
    #[error("--set {word}: {why}")]
    Set { word: String, why: SetError },
}

/// A word of `--set` cannot be put over the configuration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SetError {
    /// There is no `=` in it.
    #[error("write KEY=VALUE, for instance rpc.max_streams=8")]
    NoValue,
    /// A part of the key stands for a plain value.
    #[error("{key} is a {ty} and has no `{member}`")]
    NoTable { key: String, ty: &'static str, member: String },
    /// No such key, or a value of the wrong type.
    #[error("{message}{}", suggestion(.nearest))]
    Unreadable { message: String, nearest: Option<String> },
}

impl From<toml::de::Error> for SetError {
    fn from(error: toml::de::Error) -> Self {
        let message = error.message().trim().replace('\n', ", ");
        Self::Unreadable { nearest: nearest_key(&message), message }
    }
}

/// A filter of logs names a level that is none.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{word}` is no level of logs: error, warn, info, debug or trace, or for a part such as \
     info,genomd=debug{}", suggestion(.nearest)
)]
pub struct NoLevel {
    pub(crate) word: String,
    pub(crate) nearest: Option<String>,
}

/// A task cannot run with this period.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("period_ms = {0} is no period")]
pub struct NoPeriod(pub(crate) f64);

/// A file describes several daemons, and which of them is meant is not said, or is none of them.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}; say with --daemon which of these it is: {}", wrong(.given.as_deref()), names.join(", "))]
pub struct WhichDaemon {
    pub(crate) given: Option<String>,
    pub(crate) names: Vec<String>,
}

fn wrong(given: Option<&str>) -> String {
    match given {
        Some(given) => format!("the file describes no daemon `{given}`"),
        None => "the file describes several daemons".to_owned(),
    }
}

fn suggestion(nearest: &Option<String>) -> String {
    nearest.as_ref().map(|name| format!("; did you mean `{name}`?")).unwrap_or_default()
}
