//! Errors of connecting and disconnecting.

use genom_middleware::OpenError;
use genom_protocol::Code;
use genom_registry::BackendError;
use genom_runtime::HeldUp;

use super::opening::BindError;

/// Kind of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An in port to an out port.
    Port,
    /// A remote to a service.
    Service,
}

/// Why a connection could not be made. The previous connection, if any, is kept.
#[derive(Debug, thiserror::Error)]
pub enum ConnectError {
    /// This daemon has no such in port, or no such remote.
    #[error("{}: {message}{}", .kind.no_such_inport(), .kind.told(.help))]
    NoSuchInport {
        /// Whether an in port or a remote was expected.
        kind: Kind,
        /// The message, as a sentence.
        message: String,
        /// What the user can do.
        help: String,
    },
    /// There is no such out port, or no such service.
    #[error("{}: {message}{}", .kind.no_such_outport(), .kind.told(.help))]
    NoSuchOutport {
        /// Whether an out port or a service was expected.
        kind: Kind,
        /// The message, as a sentence.
        message: String,
        /// What the user can do.
        help: String,
        /// Whether it may appear later.
        absent: bool,
    },
    /// A policy was given for a remote.
    #[error("{remote} is a remote: it takes a service, and no policy")]
    Policy {
        /// Address of the remote.
        remote: String,
    },
    /// The two sides carry different types.
    #[error("{message}")]
    Type {
        /// Message with both addresses and types.
        message: String,
        /// What the user can do, unless the message says it.
        help: Option<&'static str>,
    },
    /// There is no such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The middleware reported an error.
    #[error(transparent)]
    Failed(Box<OpenError>),
    /// The out port cannot be opened on the middleware that was asked for.
    #[error("{outport} cannot be opened on {over}: {source}")]
    End {
        /// The out port.
        outport: String,
        /// Name of the middleware.
        over: String,
        /// Why.
        source: Box<BindError>,
    },
    /// A reader in another process asks for a middleware that does not leave one.
    #[error("{outport} is read in another process, and {over} does not leave one")]
    Stays {
        /// The out port.
        outport: String,
        /// Name of the middleware.
        over: String,
    },
    /// A codel of the reader or caller does not return.
    #[error(transparent)]
    HeldUp(#[from] HeldUp),
}

impl Kind {
    fn no_such_inport(self) -> Code {
        match self {
            Kind::Port => Code::NoSuchInport,
            Kind::Service => Code::NoSuchRemote,
        }
    }

    fn no_such_outport(self) -> Code {
        match self {
            Kind::Port => Code::NoSuchOutport,
            Kind::Service => Code::NoSuchService,
        }
    }

    /// The help as part of the message, for services; for ports it is reported separately.
    fn told(self, help: &str) -> String {
        match self {
            Kind::Port => String::new(),
            Kind::Service => format!("; {help}"),
        }
    }
}

impl ConnectError {
    /// The stable name of the reason, for programs.
    #[must_use]
    pub fn code(&self) -> Code {
        match self {
            ConnectError::NoSuchInport { kind, .. } => kind.no_such_inport(),
            ConnectError::NoSuchOutport { kind, .. } => kind.no_such_outport(),
            ConnectError::Type { .. } => Code::TypeMismatch,
            ConnectError::Policy { .. } | ConnectError::Backend(_) | ConnectError::Stays { .. } => {
                Code::BadInput
            }
            ConnectError::Failed(_) | ConnectError::End { .. } => Code::MiddlewareFailed,
            ConnectError::HeldUp(_) => Code::HeldUp,
        }
    }

    /// The key of the connection's entry that the error is about.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match self {
            ConnectError::NoSuchInport { .. } | ConnectError::HeldUp(_) => "in",
            ConnectError::NoSuchOutport { .. }
            | ConnectError::Type { .. }
            | ConnectError::Failed(_)
            | ConnectError::End { .. } => "out",
            ConnectError::Policy { .. } => "policy",
            ConnectError::Backend(_) | ConnectError::Stays { .. } => "over",
        }
    }

    /// The message without the help that [`help`](Self::help) returns.
    #[must_use]
    pub fn message(&self) -> String {
        match self {
            ConnectError::NoSuchInport { kind: Kind::Port, message, .. }
            | ConnectError::NoSuchOutport { kind: Kind::Port, message, .. } => message.clone(),
            error => error.to_string(),
        }
    }

    /// Whether the other side does not exist yet and may appear later.
    #[must_use]
    pub fn is_absent(&self) -> bool {
        matches!(self, ConnectError::NoSuchOutport { absent: true, .. })
    }

    /// What the user can do, unless the message says it.
    #[must_use]
    pub fn help(&self) -> Option<&str> {
        match self {
            ConnectError::NoSuchInport { kind: Kind::Port, help, .. }
            | ConnectError::NoSuchOutport { kind: Kind::Port, help, .. } => Some(help),
            ConnectError::Type { help, .. } => *help,
            ConnectError::Stays { .. } => {
                Some("name another middleware, or none for shared memory")
            }
            _ => None,
        }
    }

    /// Message and help in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        match self.help() {
            Some(help) => format!("{self}; {help}"),
            None => self.to_string(),
        }
    }

    pub(super) fn inport(kind: Kind, message: impl Into<String>, help: impl Into<String>) -> Self {
        ConnectError::NoSuchInport { kind, message: message.into(), help: help.into() }
    }

    pub(super) fn outport(kind: Kind, message: impl Into<String>, help: impl Into<String>) -> Self {
        let (message, help) = (message.into(), help.into());
        ConnectError::NoSuchOutport { kind, message, help, absent: false }
    }
}

impl From<OpenError> for ConnectError {
    fn from(error: OpenError) -> Self {
        ConnectError::Failed(Box::new(error))
    }
}
