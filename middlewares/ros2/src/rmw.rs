//! What ROS stands on, as in ROS itself an `rmw`: above are names, types, hashes, actions,
//! parameters and masquerades; below are topics and services whose bodies are bytes, and what is
//! known of others. DDS and zenoh each implement it.

use std::collections::HashSet;
use std::sync::Arc;
use std::time::Instant;

use crate::dds::rustdds::dds::CreateError;
use genom_middleware::{
    Address, CallError, Endpoint, EndpointKind, Obstacle, OpenError, Policy, PortSpec, Publisher,
    Refused, Subscription,
};
use genom_rosidl::TypeName;

/// Size in bytes of the encapsulation header before a payload.
pub(crate) const HEADER: usize = 4;

/// Identifies a writer, reader, server or client: `rmw_gid_t`, since ROS 2 Iron.
pub(crate) type Gid = [u8; 16];

/// A topic or a service: what its ends must agree on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Named {
    /// Without the leading slash: `demo/position`, `demo/goto/_action/send_goal`.
    pub(crate) name: String,
    pub(crate) ty: TypeName,
    /// Hash of the type; `None` if a type within it is unknown or ROS has none like it.
    pub(crate) hash: Option<String>,
}

/// An end that is to be opened.
#[derive(Clone, Debug)]
pub(crate) struct Wanted {
    pub(crate) kind: EndpointKind,
    /// The address with the namespace in front.
    pub(crate) address: String,
    /// The types as error messages spell them.
    pub(crate) types: String,
    pub(crate) digest: String,
    /// The topic or service; of an action, the service that takes its goals.
    pub(crate) of: Named,
    /// The ROS node that it belongs to, with its namespace in front: that of the component.
    pub(crate) node: String,
}

/// Writers and readers of a node.
#[derive(Clone, Debug, Default)]
pub(crate) struct Entities {
    /// The first writer or reader identifies the end in announcements.
    pub(crate) writers: Vec<Gid>,
    pub(crate) readers: Vec<Gid>,
}

/// What is known of a service that is to be called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Service {
    /// It exists. With its server; `None` if that is in this daemon.
    There(Option<Gid>),
    Nobody,
    /// It has these types instead.
    Differs(String),
}

/// Who is to get a message, where there are several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// This end.
    End(Gid),
    /// The end of that name that is where this end is: in the same DDS participant.
    Beside(Gid),
}

/// An end cannot be made.
#[derive(Debug, thiserror::Error)]
pub(crate) enum EndError {
    #[error(transparent)]
    Dds(#[from] CreateError),
    #[error("{0}")]
    Zenoh(#[from] zenoh::Error),
    #[error(
        "{0} has no type hash, by which ROS nodes on zenoh recognise it: `genomctl ros2-package` \
         says what ROS lacks"
    )]
    NoHash(TypeName),
}

/// Called for each request, with where its reply goes, and its message.
pub(crate) type OnRequest = Box<dyn Fn(Box<dyn Reply>, &[u8]) + Send + Sync>;

/// Called for each message of a topic.
pub(crate) type OnMessage = Box<dyn Fn(&[u8]) + Send + Sync>;

/// Where the reply to one request goes. Without one, the client waits until its timeout.
pub(crate) trait Reply: Send {
    /// Sends the reply. `body` is CDR, little endian, without header.
    fn send(self: Box<Self>, body: Vec<u8>);

    /// The client.
    fn asker(&self) -> Gid;
}

/// The serving end of a service. It ends when this is dropped.
pub(crate) trait ServerEnd: Send + Sync {
    fn entities(&self) -> Entities;

    /// Takes no more requests; those that were taken can still be answered.
    fn withdraw(&self);

    /// Waits for a limited time until the replies have arrived.
    fn flush(&self);
}

/// The calling end of a service, shared by all callers in this daemon.
pub(crate) trait ClientEnd: Send + Sync {
    /// Sends a request as soon as it can arrive. `body` is CDR, little endian, without header.
    fn call(&self, to: Target, body: Vec<u8>, answer: Answer);
}

/// The writing end of a topic that is no port.
pub(crate) trait TopicWriter: Send + Sync {
    fn entities(&self) -> Entities;

    /// Sends a message in CDR, little endian, without header; to the side of that client only,
    /// where that is possible.
    fn send(&self, to: Option<Gid>, body: Vec<u8>);

    /// Waits for a limited time until all has arrived.
    fn flush(&self);
}

/// Keeps an end of ours registered, here and for others.
pub(crate) trait Claim: Send {
    /// Its entities exist now.
    fn made(&self, entities: Entities);
}

/// One way of ROS 2 to communicate.
pub(crate) trait Rmw: Send + Sync {
    fn publisher(
        &self,
        port: &PortSpec<'_>,
        wanted: Wanted,
    ) -> Result<Box<dyn Publisher>, OpenError>;

    fn subscription(
        &self,
        port: &PortSpec<'_>,
        policy: Policy,
        wanted: Wanted,
    ) -> Result<Box<dyn Subscription>, OpenError>;

    /// Registers a service of ours, unless it conflicts with another end.
    fn claim(&self, at: &Address, wanted: &Wanted) -> Result<Box<dyn Claim>, OpenError>;

    /// Registers entities of a node that are not an end of ours, until the result is dropped.
    fn belong(&self, node: &str, entities: Entities) -> Box<dyn Send + Sync>;

    /// `node` is the node that has it, with its namespace in front, as in the functions below.
    fn server(
        &self,
        node: &str,
        of: &Named,
        on_request: OnRequest,
    ) -> Result<Box<dyn ServerEnd>, EndError>;

    fn caller(&self, node: &str, of: &Named) -> Result<Box<dyn ClientEnd>, EndError>;

    /// With `latched`, a late reader gets the last message if it asks for it.
    fn writer(
        &self,
        node: &str,
        of: &Named,
        latched: bool,
    ) -> Result<Arc<dyn TopicWriter>, EndError>;

    /// Reads a topic until the result is dropped.
    fn reader(
        &self,
        node: &str,
        of: &Named,
        on_message: OnMessage,
    ) -> Result<Box<dyn Send + Sync>, EndError>;

    /// Whether a service exists, and its types if they are known to differ. Waits until `end` for
    /// one that is not known, since discovery takes time.
    fn service(&self, wanted: &Wanted, end: Instant) -> Service;

    /// The nodes that have ends here.
    fn nodes(&self) -> HashSet<String>;

    /// Waits for a limited time until others know what was opened and closed here.
    fn settle(&self);

    /// Distinguishes this daemon from others.
    fn mark(&self) -> [u8; 8];

    fn list(&self) -> Vec<Endpoint>;

    /// What keeps ends of others on a topic from connecting to ours.
    fn obstacles(&self, at: &Address, topic: &str) -> Vec<Obstacle>;

    /// What keeps this process from others. May take some seconds.
    fn trouble(&self) -> Vec<Obstacle> {
        Vec::new()
    }

    fn refused(&self) -> Vec<Refused> {
        Vec::new()
    }

    /// Blocks the out port that was opened first from sending until the result is dropped.
    fn stall(&self) -> Box<dyn Send>;
}

type Then = Box<dyn FnOnce(Result<&[u8], CallError>) + Send>;

/// Receives the message of a reply, or the error. Always called: with [`CallError::Gone`] if it is
/// dropped.
pub(crate) struct Answer(Option<Then>);

impl Answer {
    pub(crate) fn new(then: impl FnOnce(Result<&[u8], CallError>) + Send + 'static) -> Self {
        Self(Some(Box::new(then)))
    }

    pub(crate) fn give(mut self, answer: Result<&[u8], CallError>) {
        if let Some(then) = self.0.take() {
            then(answer);
        }
    }
}

impl Drop for Answer {
    fn drop(&mut self) {
        if let Some(then) = self.0.take() {
            then(Err(CallError::Gone));
        }
    }
}
