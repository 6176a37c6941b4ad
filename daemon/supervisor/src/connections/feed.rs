//! Publishing to an in port from outside: a supervisor or a simulator feeds a component.
//!
//! Nobody else writes under an in port's own address, so that is where such values go: the in
//! port is connected to itself, and whoever opens a publisher there feeds it. The daemon does for
//! callers of its control plane; a program that speaks the middleware may do so itself.

use genom_description::model::PortDirection;
use genom_middleware::{OpenError, Policy, PortSpec, PublishError};
use genom_ports::{Feed, PortKey};
use genom_registry::BackendError;
use genom_runtime::HeldUp;
use genom_types::{CdrError, JsonError, Record};

use super::core::Connections;
use super::port::{AttachError, Source};
use crate::components::Hosted;
use crate::ties::PortConnection;

/// A value could not be published; the port keeps the one it had.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum FeedError {
    /// Codels write out ports.
    #[error("{0} is an out port: its codels write it, nobody else")]
    OutPort(String),
    /// Something else feeds the port.
    #[error("{inport} reads {outport}")]
    Connected { inport: String, outport: String },
    /// The value is not one of the port's type.
    #[error(transparent)]
    Value(#[from] JsonError),
    /// The message is not one of the port's type.
    #[error(transparent)]
    Message(#[from] CdrError),
    /// No such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The middleware refused the publisher or the connection.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The middleware refused the value.
    #[error("{inport} takes no value: {source}")]
    Publish { inport: String, source: PublishError },
    /// A codel does not return, so the port cannot be connected.
    #[error(transparent)]
    HeldUp(#[from] HeldUp),
}

impl From<AttachError> for FeedError {
    fn from(error: AttachError) -> Self {
        match error {
            AttachError::Open(error) => Self::Open(error),
            AttachError::HeldUp(error) => Self::HeldUp(error),
        }
    }
}

impl Connections {
    /// Publishes what `fill` makes of the value published last, at first zero, and connects the
    /// port the first time. What `tell` makes of what the port has now.
    ///
    /// Blocks while codels are excluded. A port that something else feeds stays as it is: taking a
    /// robot's sensor away is done on purpose, by disconnecting it.
    ///
    /// # Errors
    /// The port takes no value from outside, or not this one; it keeps the one it had.
    pub fn feed<T>(
        &self,
        hosted: &Hosted,
        key: &PortKey,
        fill: impl FnOnce(&mut Record) -> Result<(), FeedError>,
        tell: impl FnOnce(&Record) -> T,
    ) -> Result<T, FeedError> {
        let inport = hosted.port_address(key);
        let is_in = hosted.model().ports[key.port].direction == PortDirection::In;
        let Some(ty) = hosted.port_type(key.port).filter(|_| is_in) else {
            return Err(FeedError::OutPort(inport.to_string()));
        };
        // Held throughout: of two callers that publish first, one opens the publisher.
        hosted.ties.feeds.hold(|feeds| {
            let connection = hosted.ties.connection(key);
            if let Some(PortConnection { outport, .. }) = &connection
                && *outport != inport
            {
                let (inport, outport) = (inport.to_string(), outport.to_string());
                return Err(FeedError::Connected { inport, outport });
            }
            let name = inport.to_string();
            let refused = |source| FeedError::Publish { inport: name.clone(), source };
            let mut value = Record::new(ty);
            if let Some(feed) = feeds.get_mut(key) {
                // Of one type: copying cannot fail.
                let _ = value.copy_from(&feed.value);
                fill(&mut value)?;
                feed.publisher.publish(&value).map_err(refused)?;
                feed.value = value;
                return Ok(tell(&feed.value));
            }
            fill(&mut value)?;
            // Connected to itself before: on the middleware that was asked for then.
            let backend = match &connection {
                Some(made) => made.backend.clone(),
                None => hosted.backends_of(key).first().to_owned(),
            };
            let middleware = self.backends.get(&backend)?;
            let mut publisher =
                middleware.publisher(&PortSpec::new(&inport, ty).of(hosted.quality(key)))?;
            // Before the port is connected: the first thing it reads is this value.
            publisher.publish(&value).map_err(refused)?;
            if connection.is_none() {
                let source = Source { outport: inport, policy: Policy::Latest, fixed: false };
                self.attach(hosted, key, &middleware, source)?;
            }
            let told = tell(&value);
            feeds.insert(key.clone(), Feed { publisher, value });
            Ok(told)
        })
    }
}
