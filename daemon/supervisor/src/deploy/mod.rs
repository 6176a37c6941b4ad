//! Deployments: what is to run and how it is wired, brought about step by step.

pub mod apply;
pub mod dump;
mod error;
pub mod plan;
mod undo;

pub use error::{MoveError, StepError};

use std::fmt;

use genom_configuration::{BackendNames, CallEntry, ConnectionEntry, LoadRequest};

/// One step on the way to a deployment.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A component is to run, with its attributes set.
    Load(Box<LoadRequest>),
    /// A component is to be loaded anew, since it differs in what cannot be changed while it runs.
    Reload {
        /// The component as it is to be.
        request: Box<LoadRequest>,
        /// What differs.
        why: &'static str,
    },
    /// A component is to go.
    Unload(String),
    /// An in port or a remote is to be connected no more.
    Disconnect(ConnectionEntry),
    /// A component or port is to move to other middlewares.
    Move {
        /// Instance name.
        component: String,
        /// The port, when it is one alone.
        port: Option<String>,
        /// The middlewares it is to be on.
        to: BackendNames,
    },
    /// An attribute is to have other inputs.
    Set(CallEntry),
    /// An in port or a remote is to be connected.
    Connect(ConnectionEntry),
    /// A service is to be called.
    Call(CallEntry),
    /// An activity is to be started.
    Start(CallEntry),
}

impl Step {
    /// The connection it makes, if it makes one.
    fn connection(&self) -> Option<&ConnectionEntry> {
        if let Step::Connect(entry) = self { Some(entry) } else { None }
    }
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let call = |f: &mut fmt::Formatter<'_>, word: &str, entry: &CallEntry| {
            write!(f, "{word} {}/{} {}", entry.component, entry.service, entry.inputs)
        };
        match self {
            Step::Load(request) => {
                write!(f, "load {} from {}", request.instance(), request.library.display())?;
                request.backend.as_ref().map_or(Ok(()), |backend| write!(f, " on {backend}"))
            }
            Step::Reload { request, why } => write!(f, "reload {}: {why}", request.instance()),
            Step::Unload(name) => write!(f, "unload {name}"),
            Step::Disconnect(entry) => write!(f, "disconnect {entry}"),
            Step::Move { component, port: None, to } => write!(f, "move {component} to {to}"),
            Step::Move { component, port: Some(port), to } => {
                write!(f, "move {component}/{port} to {to}")
            }
            Step::Set(entry) => call(f, "set", entry),
            Step::Connect(entry) => write!(f, "connect {entry}"),
            Step::Call(entry) => call(f, "call", entry),
            Step::Start(entry) => call(f, "start", entry),
        }
    }
}
