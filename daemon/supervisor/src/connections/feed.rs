//! Publishes values to an in port from outside, for supervisors and simulators.
//!
//! Nobody else publishes under an in port's own address. Such values therefore go there: the in
//! port is connected to its own address, and receives from any publisher opened at it. The daemon
//! does this for clients of its control plane; a program may also publish on the middleware itself.

use genom_description::model::PortDirection;
use genom_middleware::{OpenError, Policy, PortSpec, PublishError};
use genom_ports::{Feed, PortKey};
use genom_registry::BackendError;
use genom_runtime::HeldUp;
use genom_types::{BytesError, CdrError, JsonError, Record};

use super::core::Connections;
use super::port::{AttachError, Source};
use crate::components::Hosted;

/// Why a value was not published. The port keeps its last value.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the fields are")]
pub enum FeedError {
    /// The port is an out port, which codels write.
    #[error("{0} is an out port: its codels write it, nobody else")]
    OutPort(String),
    /// The port is connected to something else.
    #[error("{inport} reads {outport}")]
    Connected { inport: String, outport: String },
    /// The JSON is not a value of the port's type.
    #[error(transparent)]
    Value(#[from] JsonError),
    /// The CDR message is not a value of the port's type.
    #[error(transparent)]
    Message(#[from] CdrError),
    /// The bytes are not a value of the port's type.
    #[error(transparent)]
    Bytes(#[from] BytesError),
    /// There is no such middleware.
    #[error(transparent)]
    Backend(#[from] BackendError),
    /// The middleware refused to open the publisher or the connection.
    #[error(transparent)]
    Open(#[from] OpenError),
    /// The middleware did not take the value.
    #[error("{inport} takes no value: {source}")]
    Publish { inport: String, source: PublishError },
    /// A codel does not return, so that the port cannot be connected.
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
    /// Publishes a value to an in port. `fill` modifies a copy of the value published last (zero at
    /// first) into the new value; `tell` converts the published value for the caller. The first
    /// call connects the port.
    ///
    /// Blocks while codels are excluded. A port that is connected to something else is refused: the
    /// user has to disconnect it first.
    ///
    /// # Errors
    /// The port cannot take values from outside, or this value is not valid. The port keeps its
    /// last value.
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
        // Locked throughout: if two callers publish first, only one opens the publisher.
        hosted.ties.feeds.hold(|feeds| {
            if let Some(outport) = hosted.ties.reads_other(key, &inport) {
                let (inport, outport) = (inport.to_string(), outport.to_string());
                return Err(FeedError::Connected { inport, outport });
            }
            let refused = |source| FeedError::Publish { inport: inport.to_string(), source };
            let mut value = Record::new(ty);
            if let Some(feed) = feeds.get_mut(key) {
                // Cannot fail: both records have the same type.
                let _ = value.copy_from(&feed.value);
                fill(&mut value)?;
                feed.publisher.publish(&value).map_err(refused)?;
                feed.value = value;
                return Ok(tell(&feed.value));
            }
            fill(&mut value)?;
            // The port is connected to its own address already: use the middleware of that
            // connection.
            let connection = hosted.ties.connection(key);
            let backend = match &connection {
                Some(made) => made.backend.clone(),
                None => hosted.backends_of(key).first().to_owned(),
            };
            let middleware = self.backends.get(&backend)?;
            let mut publisher =
                middleware.publisher(&PortSpec::new(&inport, ty).of(hosted.quality(key)))?;
            // Published before the port is connected, so that the first sample read is this value.
            publisher.publish(&value).map_err(refused)?;
            if connection.is_none() {
                let source =
                    Source { outport: inport.clone(), policy: Policy::Latest, fixed: false };
                self.attach(hosted, key, &middleware, source)?;
            }
            let told = tell(&value);
            feeds.insert(key.clone(), Feed { publisher, value });
            Ok(told)
        })
    }
}
