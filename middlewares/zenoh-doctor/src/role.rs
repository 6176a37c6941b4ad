//! What a session needs to do with a key, and which messages that takes.

use genom_middleware::EndpointKind;

/// What a session needs to do with a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Publishes.
    Writes,
    /// Subscribes.
    Reads,
    /// Answers queries.
    Serves,
    /// Tells others that something of that name is there.
    Shows,
}

impl From<EndpointKind> for Role {
    fn from(kind: EndpointKind) -> Self {
        match kind {
            EndpointKind::Publisher => Self::Writes,
            EndpointKind::Subscription => Self::Reads,
            EndpointKind::Service => Self::Serves,
        }
    }
}

impl Role {
    /// Messages that have to pass, and in which direction.
    pub(crate) fn needs(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Self::Writes => &[("put", "egress")],
            Self::Reads => &[("declare_subscriber", "egress"), ("put", "ingress")],
            Self::Serves => {
                &[("declare_queryable", "egress"), ("query", "ingress"), ("reply", "egress")]
            }
            Self::Shows => &[("liveliness_token", "egress")],
        }
    }
}
