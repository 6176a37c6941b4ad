//! Publishing to an in port from outside: a supervisor or a simulator feeds a component.
//!
//! Nobody else writes under an in port's own address, so that is where such values go: the in
//! port is connected to itself, and whoever opens a publisher there feeds it. The daemon does for
//! callers of its control plane; a program that speaks the middleware may do so itself.

use std::sync::Arc;

use genom_description::model::PortDirection;
use genom_middleware::{OpenError, Policy, PortSpec, PublishError};
use genom_ports::{Feed, key};
use genom_runtime::HeldUp;
use genom_types::{CdrError, JsonError, Record};

use super::connect;
use super::connect::{AttachError, Source};
use crate::daemon::Daemon;
use crate::hosting::Hosted;
use crate::wires::Connection;
use genom_registry::BackendError;

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

/// Publishes what `fill` makes of the value published last, at first zero, and connects the port
/// the first time. What `tell` makes of what the port has now.
///
/// Blocks while codels are excluded. A port that something else feeds stays as it is: taking a
/// robot's sensor away is done on purpose, by disconnecting it.
pub fn publish<T>(
    daemon: &Arc<Daemon>,
    hosted: &Arc<Hosted>,
    port: usize,
    element: Option<&str>,
    fill: impl FnOnce(&mut Record) -> Result<(), FeedError>,
    tell: impl FnOnce(&Record) -> T,
) -> Result<T, FeedError> {
    let model = &hosted.model().ports[port];
    let inport = hosted.address(&model.name, element);
    let Some(ty) = hosted.port_type(port).filter(|_| model.direction == PortDirection::In) else {
        return Err(FeedError::OutPort(inport.to_string()));
    };
    let key = key(port, element);
    // Held throughout: of two callers that publish first, one opens the publisher.
    hosted.wires.feeds.hold(|feeds| {
        let connection = hosted.wires.connection(port, element);
        if let Some(Connection { outport, .. }) = &connection
            && *outport != inport
        {
            let (inport, outport) = (inport.to_string(), outport.to_string());
            return Err(FeedError::Connected { inport, outport });
        }
        let refused = |source| FeedError::Publish {
            inport: hosted.address(&model.name, element).to_string(),
            source,
        };
        let mut value = Record::new(ty);
        if let Some(feed) = feeds.get_mut(&key) {
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
            None => hosted.wires.bindings.port(&model.name).first().to_owned(),
        };
        let middleware = daemon.backends.get(&backend)?;
        let quality = hosted.wires.bindings.quality(&model.name);
        let mut publisher = middleware.publisher(&PortSpec::new(&inport, ty).of(quality))?;
        // Before the port is connected: the first thing it reads is this value.
        publisher.publish(&value).map_err(refused)?;
        if connection.is_none() {
            let source = Source { outport: inport, policy: Policy::Latest, fixed: false };
            connect::attach(daemon, hosted, port, element, &middleware, source)?;
        }
        let told = tell(&value);
        feeds.insert(key, Feed { publisher, value });
        Ok(told)
    })
}
