//! One step of a deployment, and how it is described to users.

use std::fmt;

use genom_configuration::{BackendNames, CallEntry, ConnectionEntry, LoadRequest};

/// A step towards a deployment.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Loads a component and sets its attributes.
    Load(Box<LoadRequest>),
    /// Unloads a component and loads it again, because it differs in something that cannot change
    /// while it runs.
    Reload {
        /// The request that loads it.
        request: Box<LoadRequest>,
        /// What differs.
        why: &'static str,
    },
    /// Unloads a component.
    Unload(String),
    /// Disconnects an in port or a remote.
    Disconnect(ConnectionEntry),
    /// Moves a component or port to other middlewares.
    Move {
        /// Instance name.
        component: String,
        /// Name of the port, if only one moves.
        port: Option<String>,
        /// The new middlewares.
        to: BackendNames,
    },
    /// Sets an attribute.
    Set(CallEntry),
    /// Connects an in port or a remote.
    Connect(ConnectionEntry),
    /// Calls a service and waits for its end.
    Call(CallEntry),
    /// Starts an activity.
    Start(CallEntry),
}

impl Step {
    /// The connection that the step makes, if it makes one.
    pub(super) fn connection(&self) -> Option<&ConnectionEntry> {
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
