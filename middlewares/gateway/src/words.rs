//! What a proxy and a gateway say to each other.
//!
//! Samples are frames of their own kind ([`wire`](crate::wire)); all else is one of these messages,
//! some with a record in CDR behind it.

use std::borrow::Cow;
use std::time::Duration;

use genom_middleware::{
    ActivityId, Address, AnnounceError, AskError, CallError, Capabilities, Diagnosis,
    DiscoverError, Endpoint, LogEntry, NoForeignName, Obstacle, OpenError, Outcome, Policy,
    Quality, Refused, ServiceKind, ServiceType, Stranger,
};
use genom_types::{DataType, Definition, DefinitionError, Record};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Both sides must have the same number. It changes with the meaning of what is sent.
pub(crate) const PROTOCOL: u32 = 3;

/// From a proxy to its gateway.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Up {
    /// Comes first.
    Hello { protocol: u32 },
    /// Opens an end under a number that the proxy chose.
    Open { end: u32, what: What },
    /// Closes it.
    Close { end: u32 },
    /// A request of a client. Its input follows.
    Request { end: u32, call: u64 },
    /// Cancels a request of a client.
    Cancel { call: u64 },
    /// What became of a request that the gateway passed on.
    Progress { call: u64, progress: Progress },
    /// The reply to a message for a daemon, which follows; or there will be none.
    Reply { call: u64, replied: bool },
    /// Shows a type or service under a foreign name, or no more.
    Mask { ours: String, foreign: Option<String> },
    /// An entry of a component's log.
    Log(LogEntry),
    /// How tasks of components fare.
    Diagnose(Vec<Diagnosis>),
    /// A question; that of [`Question::Ask`] has a message behind it.
    Question { number: u64, question: Question },
}

/// From a gateway to a proxy.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Down {
    /// Comes first.
    Welcome { protocol: u32, about: About },
    /// An end was opened.
    Opened { end: u32 },
    /// An end could not be opened.
    Refused { end: u32, why: Refusal },
    /// An end was closed.
    Closed { end: u32 },
    /// How many samples of an end were lost in the gateway and behind it so far.
    Lost { end: u32, count: u64 },
    /// A request to a service of the proxy's process. Its input follows.
    Request { end: u32, call: u64 },
    /// A caller cancels an activity.
    Cancel { end: u32, id: ActivityId },
    /// What became of a request of a client.
    Progress { call: u64, progress: Progress },
    /// A message for a daemon, which follows.
    Relayed { end: u32, call: u64 },
    /// The answer to a question.
    Answer { number: u64, answer: Answer },
}

/// An end of the middleware.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum What {
    Publisher { address: Address, ty: Definition, quality: Quality },
    Subscription { address: Address, ty: Definition, quality: Quality, policy: Policy },
    Served { address: Address, service: Service },
    Client { address: Address, service: Service },
    Announcement { name: String },
}

/// A [`ServiceType`] on its way.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) struct Service {
    kind: ServiceKind,
    input: Definition,
    output: Definition,
    described: String,
}

impl Service {
    pub(crate) fn of(service: &ServiceType) -> Self {
        Self {
            kind: service.kind,
            input: Definition::of(&service.input),
            output: Definition::of(&service.output),
            described: service.described.clone(),
        }
    }

    pub(crate) fn read(self) -> Result<ServiceType, DefinitionError> {
        let (input, output) = (self.input.read()?, self.output.read()?);
        Ok(ServiceType::new(self.kind, input, output).described(self.described))
    }
}

/// What a middleware is, as far as it stays the same while it is open.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct About {
    pub(crate) capabilities: Capabilities,
    pub(crate) discovers: bool,
    pub(crate) relays: bool,
    pub(crate) takes_reports: bool,
    pub(crate) meeting: Vec<(Cow<'static, str>, String)>,
    /// Identity of this end, of middlewares that relay.
    pub(crate) own: String,
    /// The address `a/b` as it is spelled there.
    pub(crate) spelled: String,
}

/// Why an end was not opened.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Refusal {
    Open(OpenError),
    Announce(AnnounceError),
    /// The gateway takes no more, or does not understand.
    Own(String),
}

/// One reply to a request.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Progress {
    Accepted(ActivityId),
    Feedback(String),
    /// The output follows.
    Success,
    Exception {
        name: String,
        detail: Value,
    },
    Lost(CallError),
}

impl Progress {
    /// An outcome, and what follows it.
    pub(crate) fn of(outcome: Outcome) -> (Self, Vec<u8>) {
        let mut payload = Vec::new();
        let progress = match outcome {
            Outcome::Success(output) => match output.encode_message(&mut payload) {
                Ok(()) => Self::Success,
                Err(error) => Self::Lost(CallError::Serialization(error.to_string())),
            },
            Outcome::Exception { name, detail } => Self::Exception { name, detail },
            Outcome::Lost(error) => Self::Lost(error),
        };
        (progress, payload)
    }

    /// The outcome that this is, with what follows it; the rest goes back.
    pub(crate) fn outcome(self, output: &DataType, payload: &[u8]) -> Result<Outcome, Self> {
        Ok(match self {
            Self::Success => {
                let mut record = Record::new(output);
                match record.decode_message(payload) {
                    Ok(()) => Outcome::Success(record),
                    Err(error) => Outcome::Lost(CallError::Serialization(error.to_string())),
                }
            }
            Self::Exception { name, detail } => Outcome::Exception { name, detail },
            Self::Lost(error) => Outcome::Lost(error),
            other => return Err(other),
        })
    }
}

/// What a middleware is asked.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Question {
    Discover,
    EndsAt(Address),
    Spelled(Address),
    Strangers,
    Obstacles(Address),
    Refused,
    Trouble,
    Mask {
        ours: String,
        foreign: String,
    },
    Daemons,
    /// A message to one end, or to all.
    Ask {
        name: String,
        at: Option<String>,
        patience: Duration,
    },
}

/// What it answers.
#[derive(Debug, Serialize, Deserialize)]
pub(crate) enum Answer {
    Endpoints(Result<Vec<Endpoint>, DiscoverError>),
    Text(String),
    Strangers(Vec<Stranger>),
    Obstacles(Vec<Obstacle>),
    Refused(Vec<Refused>),
    Masked(Result<(), NoForeignName>),
    Daemons(Result<Vec<String>, DiscoverError>),
    /// Who replied, with the sizes of the replies, which follow.
    Replies(Result<Vec<(String, usize)>, AskError>),
    /// The middleware has nothing of that kind.
    None,
}
