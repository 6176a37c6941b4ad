//! Why a connection could not be made or taken away.

use genom_middleware::OpenError;
use genom_protocol::Code;
use genom_registry::BackendError;
use genom_runtime::HeldUp;

/// What is connected: ports, or a remote and a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An in port to an out port.
    Port,
    /// A remote to a service.
    Service,
}

/// A connection could not be made; what was there before still is.
#[derive(Debug, thiserror::Error)]
pub enum ConnectError {
    /// This daemon has no such in port, or no such remote.
    #[error("{}: {message}{}", .kind.no_such_inport(), .kind.told(.help))]
    NoSuchInport {
        /// Which of the two.
        kind: Kind,
        /// A sentence.
        message: String,
        /// The way out.
        help: String,
    },
    /// There is no such out port, or no such service.
    #[error("{}: {message}{}", .kind.no_such_outport(), .kind.told(.help))]
    NoSuchOutport {
        /// Which of the two.
        kind: Kind,
        /// A sentence.
        message: String,
        /// The way out.
        help: String,
        /// It may come later.
        absent: bool,
    },
    /// A remote was given a policy.
    #[error("{remote} is a remote: it takes a service, and no policy")]
    Policy {
        /// The remote.
        remote: String,
    },
    /// The two sides carry different types.
    #[error("{message}")]
    Type {
        /// Which two, and their types.
        message: String,
        /// The way out, unless the message says it.
        help: Option<&'static str>,
    },
    /// No such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The middleware refused.
    #[error(transparent)]
    Failed(Box<OpenError>),
    /// A codel of the reader, or of the caller, does not return.
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

    /// Help as a part of the message: of ports it stands apart.
    fn told(self, help: &str) -> String {
        match self {
            Kind::Port => String::new(),
            Kind::Service => format!("; {help}"),
        }
    }
}

impl ConnectError {
    /// Its reason, for programs.
    #[must_use]
    pub fn code(&self) -> Code {
        match self {
            ConnectError::NoSuchInport { kind, .. } => kind.no_such_inport(),
            ConnectError::NoSuchOutport { kind, .. } => kind.no_such_outport(),
            ConnectError::Type { .. } => Code::TypeMismatch,
            ConnectError::Policy { .. } | ConnectError::Backend(_) => Code::BadInput,
            ConnectError::Failed(_) => Code::MiddlewareFailed,
            ConnectError::HeldUp(_) => Code::HeldUp,
        }
    }

    /// The key of a connection's entry that it is about.
    #[must_use]
    pub fn key(&self) -> &'static str {
        match self {
            ConnectError::NoSuchInport { .. } | ConnectError::HeldUp(_) => "in",
            ConnectError::NoSuchOutport { .. }
            | ConnectError::Type { .. }
            | ConnectError::Failed(_) => "out",
            ConnectError::Policy { .. } => "policy",
            ConnectError::Backend(_) => "backend",
        }
    }

    /// The message without its code, where that is told apart.
    #[must_use]
    pub fn message(&self) -> String {
        match self {
            ConnectError::NoSuchInport { kind: Kind::Port, message, .. }
            | ConnectError::NoSuchOutport { kind: Kind::Port, message, .. } => message.clone(),
            error => error.to_string(),
        }
    }

    /// Whether the other side is not there and may come.
    #[must_use]
    pub fn is_absent(&self) -> bool {
        matches!(self, ConnectError::NoSuchOutport { absent: true, .. })
    }

    /// The way out, when the message does not say it.
    #[must_use]
    pub fn help(&self) -> Option<&str> {
        match self {
            ConnectError::NoSuchInport { kind: Kind::Port, help, .. }
            | ConnectError::NoSuchOutport { kind: Kind::Port, help, .. } => Some(help),
            ConnectError::Type { help, .. } => *help,
            _ => None,
        }
    }

    /// All of it in one sentence.
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
