//! Why a component was not loaded.

use std::path::PathBuf;

use super::locate::LocateError;
use crate::connections::BindError;
use crate::known::ReadError;
use genom_configuration::NoPeriod;
use genom_registry::BackendError;

/// A component could not be loaded; nothing of it stays.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum LoadError {
    /// The daemon stops.
    #[error("the daemon stops: nothing is loaded any more")]
    Stopping,
    /// No such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// Library or description not found.
    #[error(transparent)]
    Locate(#[from] LocateError),
    /// The description cannot be used.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The instance name cannot name anything.
    #[error("`{0}` cannot name an instance: use letters, digits and _, a letter first")]
    Name(String),
    /// Another component has the name.
    #[error("a component named {0} runs already: give this one another name (--name)")]
    Taken(String),
    /// The library is none, or does not open.
    #[error(transparent)]
    Library(#[from] genom_host::OpenError),
    /// The library was built without a source of the component.
    #[error(
        "{}: undefined symbol `{symbol}`: {} defines it, and is not in the library: add it to the \
         sources that the library is built of",
        path.display(),
        file.display()
    )]
    LeftOut { path: PathBuf, symbol: String, file: PathBuf },
    /// The library does not fit the description.
    #[error(transparent)]
    Mismatch(#[from] genom_host::LoadErrors),
    /// A port could not be opened.
    #[error("{name}: {source}")]
    Bind { name: String, source: BindError },
    /// What the request says of a task cannot be.
    #[error("{name}: {source}")]
    Override { name: String, source: NoPeriod },
    /// An attribute did not take its initial value.
    #[error("{name} does not take its attributes: {why}")]
    Attribute { name: String, key: Vec<String>, why: String },
    /// The request names a port, task or service that the component has not.
    #[error("{name} has no {what} `{typed}`; {help}")]
    NoSuch { name: String, what: &'static str, typed: String, help: String },
    /// What the request says of the quality of a port cannot be.
    #[error("{name}/{port}: {why}")]
    Qos { name: String, port: String, why: String },
    /// A start codel failed (genom3.md 7.2).
    #[error("{name} does not start: {why}")]
    Start { name: String, why: String },
}

impl LoadError {
    /// Where the mistake is in what was asked: keys, as far as they are known.
    pub fn key(&self) -> Vec<String> {
        match self {
            LoadError::Attribute { key, .. } => key.clone(),
            LoadError::NoSuch { what, typed, .. } => vec![format!("{what}s"), typed.clone()],
            LoadError::Qos { port, .. } => ["qos", "ports", port].map(str::to_owned).to_vec(),
            LoadError::Backend(_) => vec!["backend".to_owned()],
            LoadError::Override { .. } => vec!["tasks".to_owned()],
            LoadError::Name(_) | LoadError::Taken(_) => vec!["name".to_owned()],
            LoadError::Stopping | LoadError::Bind { .. } | LoadError::Start { .. } => Vec::new(),
            _ => vec!["library".to_owned()],
        }
    }
}
