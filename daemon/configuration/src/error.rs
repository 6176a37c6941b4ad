//! Errors in the configuration, with the place of each.

use std::net::SocketAddr;
use std::path::PathBuf;

use genom_nearest::nearest_key;
use genom_protocol::LoadRequest;

/// Greatest value of `max_activities`: memory for that many is reserved when a task starts.
pub const MOST_ACTIVITIES: usize = 4096;

/// The command line contradicts itself or the configuration.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum UsageError {
    /// `--name` or `--gen` is given with no component, or with several.
    #[error("{option} goes with exactly one component, {found} are given")]
    OneComponent { option: &'static str, found: usize },
    /// `--listen` has an address that other machines can reach, without TLS.
    #[error(
        "{0} can be reached from outside: it needs TLS, `cert` and `key` in section [rpc.tls] of \
         the configuration, and tokens or client certificates; or listen on 127.0.0.1 or [::1]"
    )]
    NoTls(SocketAddr),
    /// `--listen` is given, and no tokens or client certificates.
    #[error(
        "whoever reaches {0} could command this daemon: say with --token-file FILE who may \
         (`genomctl token NAME --into FILE` begins one), or with rpc.tls.client_ca"
    )]
    Anybody(SocketAddr),
    /// `--web` has an address that other machines can reach, without TLS.
    #[error(
        "{0} can be reached from outside: the web console needs TLS there, `cert` and `key` in \
         section [rpc.tls] of the configuration; or have it on 127.0.0.1 or [::1]"
    )]
    WebNoTls(SocketAddr),
    /// A value of `[web]`.
    #[error("web.{key} = {value}: {what}")]
    Web { key: &'static str, value: String, what: String },
    /// `--foxglove` has an address that other machines can reach, without TLS or tokens.
    #[error(
        "{0} can be reached from outside: Foxglove needs TLS there, `cert` and `key` in section \
         [rpc.tls] of the configuration, and tokens, rpc.token_file; or have it on 127.0.0.1 or [::1]"
    )]
    FoxgloveNoTls(SocketAddr),
    /// A value of `[foxglove]`.
    #[error("foxglove.{key} = {value}: {what}")]
    Foxglove { key: &'static str, value: String, what: String },
    /// The node of `[container]`.
    #[error("container.node = `{0}`: use letters, digits and _, a letter first")]
    Container(String),
    /// A name in `[lifecycle]`.
    #[error("lifecycle.components: the deployment has no component `{name}`: {help}")]
    Lifecycle { name: String, help: String },
    /// `rpc.max_connections` is 0: no client could connect, not even to stop the daemon.
    #[error("rpc.max_connections = 0: the daemon would answer nobody; one at least")]
    NoConnections,
    /// `max_activities` is 0 or above [`MOST_ACTIVITIES`].
    #[error("max_activities = {0}: give 1 to {MOST_ACTIVITIES}")]
    Activities(usize),
    /// A name in `[gateways]`.
    #[error("gateways.of: {0}")]
    Gateway(String),
    /// A middleware is unknown, or a library is none.
    #[error(transparent)]
    Backend(#[from] genom_registry::BackendError),
    /// The delay of `[gateways]`.
    #[error("gateways.restart_delay_max = {value}: {least} to {most} seconds")]
    GatewayDelay { value: f64, least: f64, most: f64 },
    /// A number of `[cells]`.
    #[error("cells.{key} = {value}: {what}")]
    Cells { key: String, value: f64, what: String },
    /// A section `[runners.NAME]`.
    #[error("runners.{name}: {what}")]
    Runner { name: String, what: String },
    /// A number of `[cells.limits]` or `[cell.NAME]`.
    #[error("{key} = {value}: {what}")]
    Limit { key: String, value: i128, what: String },
    /// A value of `[blackbox]`.
    #[error("blackbox.{key} = {value}: {what}")]
    BlackBox { key: String, value: String, what: String },
    /// A pattern of `[services]` is malformed.
    #[error(
        "[services]: `{0}` is no pattern of services: write BACKEND:COMPONENT/SERVICE or \
         COMPONENT/SERVICE, with * for anything, such as zenoh:*/kill"
    )]
    Offer(String),
    /// The configuration is for several daemons, and `--daemon` does not select one.
    #[error("{}: {why}", file.display())]
    Daemon { file: PathBuf, why: WhichDaemon },
    /// `log` is not a valid filter.
    #[error("--log {0}")]
    Log(#[from] NoLevel),
    /// `telemetry.otlp` is not a valid URL of a collector.
    #[error("telemetry.otlp: {0}: write http://HOST:4318")]
    Collector(#[from] NoCollector),
}

/// Why a text is not the URL of a collector.
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
    /// The file is missing or cannot be read.
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: std::io::Error },
    /// A mistake in the file, with its line and, for a name, the nearest valid one.
    #[error("{}:{line}: {message}{}", path.display(), suggestion(.nearest))]
    Mistake { path: PathBuf, line: usize, message: String, nearest: Option<String> },
    /// A mistake in an argument of `--set`.
    #[error("--set {word}: {why}")]
    Set { word: String, why: SetError },
}

/// Why an argument of `--set` cannot be applied to the configuration.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum SetError {
    /// It contains no `=`.
    #[error("write KEY=VALUE, for instance rpc.max_streams=8")]
    NoValue,
    /// A part of the key is a plain value and has no members.
    #[error("{key} is a {ty} and has no `{member}`")]
    NoTable { key: String, ty: &'static str, member: String },
    /// There is no such key, or the value has the wrong type.
    #[error("{message}{}", suggestion(.nearest))]
    Unreadable { message: String, nearest: Option<String> },
}

impl From<toml::de::Error> for SetError {
    fn from(error: toml::de::Error) -> Self {
        let message = message_of(&error);
        Self::Unreadable { nearest: nearest_key(&message), message }
    }
}

/// What the reader of TOML says, on one line; keys that only daemons write are not offered.
pub(crate) fn message_of(error: &toml::de::Error) -> String {
    let text = error.message().trim().replace('\n', ", ");
    let internal = LoadRequest::INTERNAL.iter();
    internal.fold(text, |text, key| text.replace(&format!(", `{key}`"), ""))
}

/// A filter of the log contains an invalid level.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{word}` is no level of logs: error, warn, info, debug or trace, or for a part such as \
     info,genomd=debug{}", suggestion(.nearest)
)]
pub struct NoLevel {
    pub(crate) word: String,
    pub(crate) nearest: Option<String>,
}

/// The period is not positive and finite.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("period_ms = {0} is no period")]
pub struct NoPeriod(pub(crate) f64);

/// A file describes several daemons, and the given name is missing or is none of them.
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
