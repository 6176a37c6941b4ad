//! Errors of loading a component.

use std::path::PathBuf;

use crate::components::Unfit;
use crate::connections::BindError;
use genom_configuration::NoPeriod;
use genom_finder::LocateError;
use genom_finder::ReadError;
use genom_registry::BackendError;
use genom_rules::NoSuchRule;

/// Why a component could not be loaded. Everything done for it was undone.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum LoadError {
    /// The daemon is stopping.
    #[error("the daemon stops: nothing is loaded any more")]
    Stopping,
    /// There is no such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The library or the description was not found.
    #[error(transparent)]
    Locate(#[from] LocateError),
    /// What was kept of the description before a reload cannot be read.
    #[error("{}: the description from before the reload: {source}", file.display())]
    Kept { file: PathBuf, source: std::io::Error },
    /// The description is not valid.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The instance name is not valid.
    #[error("`{0}` cannot name an instance: use letters, digits and _, a letter first")]
    Name(String),
    /// Another component has the same name.
    #[error("a component named {0} runs already: give this one another name (--name)")]
    Taken(String),
    /// The file is not a shared library, or it cannot be opened.
    #[error(transparent)]
    Library(#[from] genom_host::OpenError),
    /// A source file of the component is missing from the library.
    #[error(
        "{}: undefined symbol `{symbol}`: {} defines it, and is not in the library: add it to the \
         sources that the library is built of",
        path.display(),
        file.display()
    )]
    LeftOut { path: PathBuf, symbol: String, file: PathBuf },
    /// The library does not match the description.
    #[error(transparent)]
    Mismatch(#[from] genom_host::LoadErrors),
    /// A port could not be opened on a middleware.
    #[error("{name}: {source}")]
    Bind { name: String, source: BindError },
    /// An option of a task is not valid.
    #[error("{name}: {source}")]
    Override { name: String, source: NoPeriod },
    /// The initial value of an attribute was refused.
    #[error("{name} does not take its attributes: {why}")]
    Attribute { name: String, key: Vec<String>, why: String },
    /// The request names a port, task or service that the component does not have.
    #[error("{name} has no {what} `{typed}`; {help}")]
    NoSuch { name: String, what: &'static str, typed: String, help: String },
    /// A rule of renaming is about an in port.
    #[error(
        "{name}: remap: {port} is an in port, which has no name of its own: connect it with \
         [[connection]] in = \"{name}/{port}\", out = \"ros2:{to}\""
    )]
    RemapsInPort { name: String, port: String, to: String },
    /// The quality of service of a port is not valid.
    #[error("{name}/{port}: {why}")]
    Qos { name: String, port: String, why: String },
    /// A rule of its supervision does not fit it.
    #[error("{name}: supervision: {source}")]
    Supervision { name: String, source: Box<NoSuchRule> },
    /// The state to go on with is wrong.
    #[error("components.{name}.{source}")]
    Resume { name: String, source: Box<Unfit> },
    /// A start codel failed (genom3.md 7.2).
    #[error("{name} does not start: {why}")]
    Start { name: String, why: String },
}

impl LoadError {
    /// Keys of the request that lead to the mistake, as far as known.
    pub fn key(&self) -> Vec<String> {
        match self {
            LoadError::Attribute { key, .. } => key.clone(),
            LoadError::RemapsInPort { .. } => vec!["remap".to_owned()],
            LoadError::NoSuch { what: "out port or service", .. } => vec!["remap".to_owned()],
            LoadError::NoSuch { what, typed, .. } => vec![format!("{what}s"), typed.clone()],
            LoadError::Qos { port, .. } => ["qos", "ports", port].map(str::to_owned).to_vec(),
            LoadError::Backend(_) => vec!["backend".to_owned()],
            LoadError::Supervision { .. } => vec!["supervision".to_owned()],
            LoadError::Override { .. } => vec!["tasks".to_owned()],
            LoadError::Name(_) | LoadError::Taken(_) => vec!["name".to_owned()],
            LoadError::Stopping
            | LoadError::Resume { .. }
            | LoadError::Bind { .. }
            | LoadError::Start { .. } => Vec::new(),
            _ => vec!["library".to_owned()],
        }
    }
}
